// The page in a real Chromium, before a real takt: what must never break. Part of the gate; more.test.mjs is beside it.
import assert from "node:assert/strict";
import { after, afterEach, before, describe, test } from "node:test";
import {
  barriers,
  close,
  launch,
  moves,
  ready,
  rests,
  SCENARIO,
  take,
  Takt,
} from "./support.mjs";
import { arm, moved, STATION, stood, TELEOPERATION } from "./stations.mjs";
import { copyFileSync, mkdtempSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

let browser;
before(async () => {
  browser = await launch();
});
after(async () => {
  await browser.close();
  Takt.killAll();
});
// Whatever a test leaves open would cost the next one its pace.
afterEach(async () => {
  for (const context of browser.contexts()) await context.close();
});

describe("a cell that is served", () => {
  let server;
  before(async () => {
    server = await Takt.start("serve", SCENARIO, "--port", "0");
  });
  after(async () => {
    assert.equal(await server.end(), 0);
  });

  test("is shown without an error, and within the policy of the page", async () => {
    const page = await ready(browser, server.url);
    await page.waitForTimeout(500);
    assert.deepEqual(page.problems, []);
    assert.match(await page.title(), /Touch/);
    assert.equal(await page.locator("#reality").innerText(), "SIM");
    assert.match(await page.locator("#age").innerText(), /^link 0\.\d s$/);
    assert.match(await page.locator("#health").innerText(), /overrun/);
    const { width, height } = await page.locator("#view canvas").boundingBox();
    assert.ok(width > 400 && height > 150);
    assert.deepEqual(await barriers(page), []);
    await close(page);
  });

  test("jogs while a button is held, and no longer", async () => {
    const page = await ready(browser, server.url);
    await take(page);
    const plus = page.getByRole("button", {
      name: "z plus, hold to move",
      exact: true,
    });
    await plus.hover();
    const before = (await server.arm()).q_commanded;
    await page.mouse.down({ button: "right" });
    await page.waitForTimeout(200);
    assert.deepEqual((await server.arm()).q_commanded, before);
    await page.mouse.up({ button: "right" });
    await moves(server, () => page.mouse.down());
    await page.mouse.up();
    await rests(server);
    // The same by the keyboard alone.
    await plus.focus();
    await moves(server, () => page.keyboard.down("Space"));
    await page.keyboard.up("Space");
    await rests(server);
    await page.locator(".keypad").focus();
    await moves(server, () => page.keyboard.down("f"));
    await page.locator("#theme").focus(); // whoever goes elsewhere lets go
    await rests(server);
    await page.keyboard.up("f");
    assert.deepEqual(page.problems, []);
    await close(page);
  });

  test("rests when the tab is closed while somebody jogs, and whoever comes next may take it", async () => {
    const page = await ready(browser, server.url);
    await take(page);
    await page
      .getByRole("button", { name: "z plus, hold to move", exact: true })
      .hover();
    await moves(server, () => page.mouse.down());
    await close(page);
    await rests(server);
    const next = await ready(browser, server.url);
    await take(next);
    await close(next);
  });

  test("stops for a page that commands nothing, by button and by Escape", async () => {
    const [driver, watcher] = [
      await ready(browser, server.url),
      await ready(browser, server.url),
    ];
    await take(driver);
    for (const stop of [
      () => watcher.getByRole("button", { name: "STOP" }).click(),
      () => watcher.keyboard.press("Escape"),
    ]) {
      await driver
        .getByRole("button", { name: "z plus, hold to move", exact: true })
        .hover();
      await moves(server, () => driver.mouse.down());
      await stop();
      await rests(server);
      await driver.locator(".said").filter({ hasText: "At rest" }).waitFor();
      await driver.mouse.up();
    }
    assert.match(await watcher.locator("#notice").innerText(), /STOP was sent/);
    await watcher.getByRole("tab", { name: /Faults/ }).click();
    await watcher
      .getByText(/STOP by/)
      .first()
      .waitFor();
    await close(driver);
    await close(watcher);
  });
});

describe("a program that runs with a page", () => {
  test("takes its token out of the address, begins when it is started, goes step by step and ends", async () => {
    const server = await Takt.start("run", SCENARIO, "--panel", "--seed", "1");
    const page = await ready(browser, server.url);
    assert.equal(page.url(), `${server.origin}/`);
    await page.getByText("nothing has moved yet").waitFor();
    await page.getByRole("button", { name: "Step", exact: true }).click();
    await page.getByText(/Waits before/).waitFor();
    assert.deepEqual(await barriers(page), []);
    await page.keyboard.press("F8"); // Continue
    await page.locator('[aria-current="step"]').first().waitFor();
    await page.keyboard.press("F9");
    await page.getByText("Paused").waitFor();
    await rests(server);
    await page.getByRole("tab", { name: "Jog" }).click();
    assert.equal(
      await page.getByRole("button", { name: /control/ }).isDisabled(),
      true,
    );
    await page.getByRole("button", { name: "STOP" }).click();
    await page.getByRole("tab", { name: "Program" }).click();
    await page.locator(".verdict").waitFor();
    assert.deepEqual(page.problems, []);
    await close(page);
    assert.notEqual(await server.end(), 0);
  });
});

describe("an operator station", () => {
  test("shows pictures and forces, is driven in a mode, and rests when its page is gone", async () => {
    const server = await Takt.start("run", TELEOPERATION, "--panel");
    const page = await ready(browser, server.url, STATION);
    await page.locator(".station").waitFor();
    await page.getByRole("button", { name: "Start" }).click();
    await page
      .locator(".pane-camera .age")
      .filter({ hasText: /^\d+ ms old/ })
      .waitFor();
    await page
      .locator(".newton")
      .nth(1)
      .filter({ hasText: /^\d+\.\d N$/ })
      .waitFor();
    assert.deepEqual(await barriers(page), []);
    await take(page);
    // The camera arm goes to its perspective, and follows the hand of the other one.
    await moved(server, "eye", () =>
      page.getByRole("button", { name: "Observer" }).click(),
    );
    await stood(server, "eye", { seconds: 20, least: 2e-4 });
    const stick = await page.locator(".station .stick").first().boundingBox();
    const [x, y] = [stick.x + stick.width / 2, stick.y + stick.height / 2];
    await page.mouse.move(x, y);
    await page.mouse.down();
    const before = (await arm(server, "eye")).q_commanded;
    await moved(server, "hand", () =>
      page.mouse.move(x, y - stick.height * 0.35),
    );
    await page.waitForTimeout(400);
    const after = (await arm(server, "eye")).q_commanded;
    assert.ok(
      after.some((one, i) => Math.abs(one - before[i]) > 1e-4),
      "the eye follows",
    );
    await page.mouse.up();
    await stood(server, "hand");
    // Another page may look, and takes over only when it says so.
    const other = await ready(browser, server.url, STATION);
    await other.getByRole("button", { name: "Take over control" }).waitFor();
    assert.equal(
      await other.getByRole("button", { name: "Direct" }).isDisabled(),
      true,
    );
    await close(other);
    await page.locator(".pane-sticks .keypad").focus();
    await moved(server, "hand", () => page.keyboard.down("r"));
    assert.deepEqual(page.problems, []);
    await close(page);
    await stood(server, "hand");
    await server.end();
  });

  test("with a broken layout is the usual page, and says what is wrong", async () => {
    const folder = mkdtempSync(join(tmpdir(), "takt-layout-"));
    copyFileSync(SCENARIO, join(folder, "cell.json"));
    writeFileSync(
      join(folder, "cell.layout"),
      '{"columns": [{"panes": [{"show": "camera", "camera": "nobody"}]}]}',
    );
    const server = await Takt.start(
      "serve",
      join(folder, "cell.json"),
      "--port",
      "0",
    );
    const page = await ready(browser, server.url);
    await page
      .locator("#notice")
      .filter({ hasText: /layout file is broken.*nobody/ })
      .waitFor();
    await page.getByRole("tab", { name: "Jog" }).waitFor();
    assert.deepEqual(page.problems, []);
    await close(page);
    assert.equal(await server.end(), 0);
  });
});
