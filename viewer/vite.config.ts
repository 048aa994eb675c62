import { defineConfig } from "vitest/config";
import { licences } from "./licences";
import { sources } from "./sources";

const plainNames = {
  entryFileNames: "assets/[name].js",
  chunkFileNames: "assets/[name].js",
  assetFileNames: "assets/[name][extname]",
};

export default defineConfig({
  base: "./",
  plugins: [licences(), sources()],
  build: {
    // The built page ships with the Python package, so that using it needs no Node.
    outDir: "../src/urushi/app/page",
    emptyOutDir: true,
    target: "es2023",
    // The content security policy forbids scripts and styles that are not files of their own.
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    // Plain names, since the built files are under version control
    rollupOptions: { output: plainNames },
  },
  // The core reads tables of the Python package, which lies beside this folder.
  server: { fs: { allow: [".."] } },
  worker: { format: "es", rollupOptions: { output: plainNames } },
  test: { include: ["tests/**/*.test.ts"], testTimeout: 60_000, hookTimeout: 60_000 },
});
