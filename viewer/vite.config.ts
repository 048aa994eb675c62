import { fileURLToPath } from "node:url";
import { defineConfig } from "vitest/config";

const standIn = fileURLToPath(new URL("tests/stand_in/remote.ts", import.meta.url));

const plainNames = {
  entryFileNames: "assets/[name].js",
  chunkFileNames: "assets/[name].js",
  assetFileNames: "assets/[name][extname]",
};

export default defineConfig(({ mode }) => ({
  base: "./",
  // `vite --mode stand-in`: the page without networks
  resolve: { alias: mode === "stand-in" ? [{ find: /^\.\/remote$/, replacement: standIn }] : [] },
  build: {
    // The built page ships with the Python package, so that using it needs no Node.
    outDir: mode === "stand-in" ? "out/stand-in" : "../src/urushi/app/page",
    emptyOutDir: true,
    target: "es2023",
    // The content security policy forbids scripts and styles that are not files of their own.
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    // Plain names, since the built files are under version control
    rollupOptions: { output: plainNames },
  },
  worker: { format: "es", rollupOptions: { output: plainNames } },
  test: { include: ["tests/**/*.test.ts"] },
}));
