"""The demo's shape: a tea caddy."""

import numpy as np

from urushi.render.scenes.turned import Profile


def natsume() -> Profile:
    """A tea caddy about 1.06 high and 1 wide: a swelling body under a gently domed lid."""
    return Profile(np.array(NATSUME))


# The lid's rim is the fine groove a third of the way down. Points close together bend sharply.
NATSUME = [
    (0.00, 0.035),
    (0.15, 0.035),
    (0.270, 0.032),
    (0.300, 0.010),
    (0.330, 0.000),
    (0.375, 0.030),
    (0.425, 0.120),
    (0.470, 0.260),
    (0.497, 0.420),
    (0.503, 0.560),
    (0.502, 0.640),
    (0.501, 0.672),
    (0.498, 0.684),
    (0.491, 0.690),
    (0.491, 0.692),
    (0.498, 0.698),
    (0.501, 0.710),
    (0.500, 0.760),
    (0.492, 0.850),
    (0.470, 0.930),
    (0.420, 0.990),
    (0.330, 1.028),
    (0.200, 1.050),
    (0.100, 1.056),
    (0.000, 1.058),
]
