/** Complex indices of refraction of metals at 630, 532 and 465 nm. */

import type { Rgb } from "./material";

/** Values of Johnson and Christy (1972), and of Rakić (1995, 1998) for aluminium and titanium. */
export const METALS: Readonly<Record<string, { eta: Rgb; k: Rgb }>> = {
  Gold: { eta: [0.18, 0.54, 1.33], k: [3.07, 2.23, 1.86] },
  Silver: { eta: [0.056, 0.054, 0.047], k: [4.28, 3.43, 2.79] },
  Copper: { eta: [0.27, 1.1, 1.24], k: [3.41, 2.59, 2.4] },
  Aluminium: { eta: [1.39, 0.88, 0.65], k: [7.65, 6.45, 5.58] },
  Iron: { eta: [2.88, 2.95, 2.65], k: [3.06, 2.93, 2.81] },
  Titanium: { eta: [2.7, 2.5, 2.2], k: [3.75, 3.4, 3.05] },
};
