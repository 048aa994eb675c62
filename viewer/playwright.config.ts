import { defineConfig } from "@playwright/test";

const PORT = 8497;

/** The page as `urushi view` serves it, in Debian's Chromium without windows, which draws less. */
export default defineConfig({
  testDir: "tests/page",
  outputDir: "out/playwright",
  // One page alone keeps two cores busy only where it draws.
  workers: 2,
  // Other programs may leave it a tenth of a core.
  timeout: 600_000,
  expect: { timeout: 60_000 },
  use: {
    baseURL: process.env.PAGE ?? `http://127.0.0.1:${PORT}/`,
    viewport: { width: 900, height: 640 },
    // One canvas pixel for several of the screen, but where tests look at pixels: the processor draws.
    deviceScaleFactor: 0.25,
    browserName: "chromium",
    launchOptions: {
      executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium-headless-shell",
      args: ["--no-sandbox"],
    },
  },
  ...(process.env.PAGE
    ? {}
    : {
        webServer: {
          command: `../.venv/bin/urushi view --no-browser --port ${PORT}`,
          url: `http://127.0.0.1:${PORT}/`,
        },
      }),
});
