// What else the page promises, in a real Chromium; by hand: node --test tests/panel/
import assert from "node:assert/strict";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, afterEach, before, describe, test } from "node:test";
import {
  barriers,
  close,
  launch,
  moves,
  open,
  ready,
  rests,
  SCENARIO,
  take,
  Takt,
} from "./support.mjs";

let browser;
before(async () => {
  browser = await launch();
});
after(async () => {
  await browser.close();
  Takt.killAll();
});
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

  for (const colorScheme of ["dark", "light"])
    test(`has no barriers, ${colorScheme}, in any tab`, async () => {
      const page = await ready(browser, server.url, { colorScheme });
      assert.equal(
        await page.locator("html").getAttribute("data-theme"),
        colorScheme,
      );
      for (const tab of await page.getByRole("tab").all()) {
        await tab.click();
        assert.deepEqual(await barriers(page), [], await tab.innerText());
      }
      await close(page);
    });

  test("jogs single joints, and with a stick", async () => {
    const page = await ready(browser, server.url);
    await take(page);
    await page.getByLabel("Space").selectOption("joints");
    const { q_commanded: before } = await server.arm();
    await page
      .getByRole("button", { name: /^\S+ plus, hold to move$/ })
      .nth(3)
      .hover();
    await moves(server, () => page.mouse.down());
    await page.mouse.up();
    await rests(server);
    const { q_commanded: after } = await server.arm();
    assert.deepEqual(
      after.map((one, i) => Math.abs(one - before[i]) > 1e-6),
      [0, 1, 2, 3, 4, 5, 6].map((joint) => joint === 3),
    );
    await page.getByLabel("Space").selectOption("tool");
    const stick = page.locator(".stick").first();
    await stick.scrollIntoViewIfNeeded();
    const { x, y, width } = await stick.boundingBox();
    await page.mouse.move(x + width / 2, y + width / 2);
    await page.mouse.down();
    await moves(server, () =>
      page.mouse.move(x + width / 2, y + 5, { steps: 5 }),
    );
    await page.mouse.up();
    await rests(server);
    assert.deepEqual(page.problems, []);
    await close(page);
  });

  test("a step ends by itself, though the button is held", async () => {
    const page = await ready(browser, server.url);
    await take(page);
    await page.getByLabel("Moves").selectOption("0.01");
    const posture = async () => (await server.arm()).q_commanded;
    const plus = page.getByRole("button", {
      name: "z plus, hold to move",
      exact: true,
    });
    await plus.hover();
    const before = await posture();
    await moves(server, () => page.mouse.down());
    await rests(server);
    const held = await posture();
    await page.waitForTimeout(500);
    assert.deepEqual(await posture(), held);
    await page.mouse.up();
    assert.notDeepEqual(held, before);
    await close(page);
  });

  test("two pages do not command at once: the one that takes over moves, the other is told", async () => {
    const [first, second] = [
      await ready(browser, server.url),
      await ready(browser, server.url),
    ];
    await take(first);
    await second.getByRole("button", { name: "Take over control" }).click();
    await second.getByRole("button", { name: "Release control" }).waitFor();
    await first.getByRole("button", { name: "Take over control" }).waitFor();
    assert.equal(
      await first
        .getByRole("button", { name: "z plus, hold to move", exact: true })
        .isDisabled(),
      true,
    );
    await close(first);
    await close(second);
  });

  test("fits a phone: STOP and jogging within reach of a thumb", async () => {
    const page = await ready(browser, server.url, {
      viewport: { width: 390, height: 844 },
      hasTouch: true,
      isMobile: true,
    });
    await take(page);
    const wide = await page.evaluate(
      () => document.documentElement.scrollWidth,
    );
    assert.ok(wide <= 390, `the page is ${wide} px wide`);
    const plus = page.getByRole("button", {
      name: "z plus, hold to move",
      exact: true,
    });
    await plus.scrollIntoViewIfNeeded();
    for (const target of [plus, page.getByRole("button", { name: "STOP" })]) {
      const box = await target.boundingBox();
      assert.ok(box.height >= 44 && box.width >= 44, JSON.stringify(box));
      assert.ok(box.y >= 0 && box.y + box.height <= 844);
    }
    await close(page);
  });
});

test("a server that starts anew is said in the page, which goes on with it and moves nothing", async () => {
  const first = await Takt.start("serve", SCENARIO, "--port", "0");
  const page = await ready(browser, first.url);
  await page.waitForTimeout(500);
  await first.end();
  await page.getByText("cannot be reached").waitFor();
  const second = await Takt.start("serve", SCENARIO, "--port", first.port);
  await page.getByText("started anew").waitFor({ timeout: 15000 });
  await page.getByText(/^link 0/).waitFor();
  assert.equal((await second.ask("GET", "/v1/state")).holder, 0);
  await close(page);
  assert.equal(await second.end(), 0);
});

test("asks for a token that is wrong or not there, and takes the right one", async () => {
  const server = await Takt.start("run", SCENARIO, "--panel");
  const page = await open(
    browser,
    `${server.origin}/#token=0123456789abcdef0123456789abcdef`,
  );
  await page.getByText("does not know this token").waitFor();
  assert.equal(await page.locator("#reality").innerText(), "");
  await page.locator("#token").fill(server.token);
  await page.getByRole("button", { name: "Connect" }).click();
  await page.getByText("SIM").waitFor();
  await close(page);
  assert.equal(await server.end(), 130);
});

test("an observer looks and stops, and commands nothing", async () => {
  const folder = mkdtempSync(join(tmpdir(), "takt-panel-"));
  const file = join(folder, "tokens");
  const [observer, operator] = [
    "0123456789abcdef-look",
    "0123456789abcdef-move",
  ];
  writeFileSync(
    file,
    `observer visitor ${observer}\noperator staff ${operator}\n`,
    { mode: 0o600 },
  );
  const server = await Takt.start(
    "serve",
    SCENARIO,
    "--port",
    "0",
    "--tokens",
    file,
  );
  server.token = operator;
  const looks = await ready(browser, `${server.origin}/#token=${observer}`);
  const commands = await ready(browser, `${server.origin}/#token=${operator}`);
  await looks.getByText("this token is an observer's").waitFor();
  assert.equal(
    await looks.getByRole("button", { name: /control/ }).isDisabled(),
    true,
  );
  await take(commands);
  await commands
    .getByRole("button", { name: "z plus, hold to move", exact: true })
    .hover();
  await moves(server, () => commands.mouse.down());
  await looks.getByRole("button", { name: "STOP" }).click();
  await rests(server);
  await looks.getByText("'staff' commands").waitFor();
  await close(looks);
  await close(commands);
  assert.equal(await server.end(), 0);
  rmSync(folder, { recursive: true });
});
