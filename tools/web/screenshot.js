// A picture of the page: node screenshot.js FOLDER-OF-FILES OUTPUT.png PARAMETERS-OF-A-LINK
import { serve, settled, startBrowser } from "./browser.js";

const [folder, output, parameters] = process.argv.slice(2);
const server = await serve([folder]);
const browser = await startBrowser({ width: 1280, height: 800 });
try {
  await browser.page.goto(`${server.url}index.html?${parameters}`);
  await settled(browser.page);
  const problem = await browser.page.locator("#problem").textContent();
  if (problem !== "") throw new Error(problem);
  await browser.page.screenshot({ path: output });
} finally {
  await browser.close();
  server.stop();
}
