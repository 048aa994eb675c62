/** The page as one document: in a frame of a notebook, and opened as a file. */

import { readFileSync } from "node:fs";
import { join } from "node:path";
import type { FrameLocator, Page } from "@playwright/test";
import { folderOfTest, python } from "../python";
import { expect, test } from "./page";

// Both workers compute.
test.use({ occlusion: true });

let folder: string;
let file: string;
let site: string;

test.beforeAll(() => {
  folder = folderOfTest();
  file = join(folder, "lacquer.html");
  site = join(folder, "site");
  python(`
from urushi.app.cli import main
main(["view", "coat(diffuse(0.5), alpha=0.2, sigma_t=1.0)", "-o", "${file}"])
main(["view", "-o", "${site}"])
`);
});

/** It begins with its material, computes, and reads its files. */
async function works(place: Page | FrameLocator, page: Page): Promise<void> {
  await expect(place.locator(".status")).toBeVisible();
  await expect(place.getByLabel("Coat 1, Roughness α, number")).toHaveValue("0.2");
  await place.getByRole("button", { name: "Add coat" }).click();
  await expect(place.getByLabel("Coat 2, Roughness α, number")).toHaveValue("0.2");
  await place.getByRole("button", { name: "Save", exact: true }).click();
  await expect(place.getByRole("button", { name: /^Copy the address/ })).toHaveCount(0);
  const download = page.waitForEvent("download");
  await place.getByRole("button", { name: "GLSL" }).click();
  expect((await download).suggestedFilename()).toBe("material.glsl");
  await expect(place.getByRole("alert")).toHaveCount(0);
}

test("a frame of a notebook holds the page", async ({ page, baseURL }) => {
  const content = readFileSync(file, "utf8").replaceAll("&", "&amp;").replaceAll('"', "&quot;");
  const body = `<!doctype html><iframe width="880" height="620" srcdoc="${content}"></iframe>`;
  const address = new URL("notebook", baseURL).href;
  await page.route(address, (route) =>
    route.fulfill({ contentType: "text/html; charset=utf-8", body }),
  );
  await page.goto(address);
  await works(page.frameLocator("iframe"), page);
});

test("a browser opens the document by itself", async ({ browser }) => {
  const page = await browser.newPage();
  const complaints: string[] = [];
  page.on("pageerror", (error) => complaints.push(String(error)));
  await page.goto(`file://${file}`);
  await works(page, page);
  expect(complaints).toEqual([]);
  await page.close();
});

test("a page for a server, opened as a file, says what to do", async ({ browser }) => {
  const page = await browser.newPage();
  await page.goto(`file://${site}/index.html`);
  await expect(page.getByText("Browsers run this page only from a web server")).toBeVisible();
  await expect(page.getByText("urushi view -o page.html")).toBeVisible();
  await page.close();
});
