import { defineConfig } from "vitest/config";

export default defineConfig({
  base: "./",
  build: {
    // The built page ships with the Python package, so that using it needs no Node.
    outDir: "../src/urushi/app/page",
    emptyOutDir: true,
    target: "es2023",
    // The content security policy forbids scripts and styles that are not files of their own.
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
  },
  worker: { format: "es" },
  test: { include: ["tests/**/*.test.ts"] },
});
