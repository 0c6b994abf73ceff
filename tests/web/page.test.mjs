// The page in Chromium: what a student does with a link, and what may go wrong meanwhile.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, readdirSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";
import { after, before, describe, test } from "node:test";

import { Browser, keyOf, scenes } from "./browser.mjs";
import { unreadable } from "./readable.mjs";

const CORNELL = "raystep:1?scene=scenes/cornell-box.gltf";
const SMALL = `${CORNELL}&size=96x96`;

/// The same on both ways of drawing; with WebGPU, kernels are asked to run on it, since a software adapter is not what
/// `auto` takes.
for (const [way, device] of [
    ["webgpu", "gpu"],
    ["webgl", "cpu"],
]) {
    describe(way, () => {
        let browser;
        before(async () => {
            browser = await Browser.open(way);
        });
        after(() => browser.close());

        test("the first picture comes by itself; how long after the files is printed", async () => {
            const tab = await browser.page();
            const { place, error, device } = await tab.settled();
            assert.deepEqual([place, error, device], [73, "", "CPU, f32"]);
            assert.equal(await tab.page.evaluate(() => window.raystep.drawnBy), way === "webgpu" ? "WebGPU" : "WebGL 2");
            await tab.screenshot(`${way}-first`);
            // Again, with files and code in the browser's cache: what remains is our own.
            await tab.page.reload();
            await tab.ready();
            await tab.page.waitForFunction(() => window.raystep.place === 73 && !window.raystep.isBusy);
            const { loaded, now } = await tab.page.evaluate(() => ({ loaded: window.raystep.loadedAt, now: performance.now() }));
            console.log(`${way}: first picture ${Math.round(now - loaded)} ms after the files have arrived`);
            assert.deepEqual(tab.troubles, []);
            await tab.page.close();
        });

        test("passes can be stepped forwards and back, and a pixel's ray followed", async () => {
            const tab = await browser.page(`${SMALL}&device=${device}&pass=0`);
            let { link } = await tab.settled();
            assert.equal(keyOf(link, "pass"), "0");
            const times = [];
            for (const [key, count, last] of [
                ["F10", 20, 20],
                ["Shift+F10", 7, 13],
            ]) {
                for (let step = 0; step < count; step += 1) {
                    // One after the other, as somebody who looks at each.
                    await tab.page.waitForTimeout(250);
                    times.push(await tab.page.evaluate(stepped, key));
                }
                const seen = await tab.settled();
                assert.deepEqual([seen.place, seen.error], [last, ""]);
            }
            times.sort((a, b) => a - b);
            console.log(`${way}: a step is shown after ${times.map(Math.round)[times.length >> 1]} ms, at most ${Math.round(times.at(-1))} ms`);
            await tab.page.mouse.click(400, 350);
            const before = keyOf(link, "pixel");
            ({ link } = await tab.settled());
            assert.notEqual(keyOf(link, "pixel"), before);
            // The address is that of the place, at most a second later.
            await tab.page.waitForTimeout(1200);
            assert.equal(decodeURIComponent(new URL(tab.page.url()).hash.slice(1)), decodeURIComponent((await tab.state()).link));
            await tab.screenshot(`${way}-stepped`);
            assert.deepEqual(tab.troubles, []);
            await tab.page.close();
        });

        test("a run stops at a watch, and a link opens another scene at its place", async () => {
            const tab = await browser.page(`${SMALL}&device=${device}&pass=0&pixel=40,50`);
            await tab.settled();
            // What is watched is the selected ray, which is selected a frame after the run is there.
            for (let turn = 0; turn < 50 && keyOf((await tab.state()).link ?? "", "pixel") !== "40,50"; turn++) {
                await tab.page.waitForTimeout(100);
            }
            await tab.press("F9");
            await tab.press("F5");
            const { place, error } = await tab.press("Escape");
            assert.equal(error, "");
            assert.ok(place > 0 && place < 70, `stopped after ${place} passes`);
            const wanted = `raystep:1?scene=teapot.glb&size=64x48&accelerator=bvh&device=${device}&pixel=30,20&pass=9&stream=state.tag`;
            const { link } = await tab.go(wanted);
            for (const key of ["scene", "size", "accelerator", "pixel", "pass", "stream"]) {
                assert.equal(keyOf(link, key), keyOf(wanted, key), key);
            }
            await tab.screenshot(`${way}-link`);
            assert.deepEqual(tab.troubles, []);
            await tab.page.close();
        });

        test("a link with shadows opens, and shows their picture", async () => {
            // With lists of live rays, but where kernels are drawn.
            const schedule = way === "webgl" ? "second" : "compact";
            const lights = `${CORNELL}&size=48x40&schedule=${schedule}&stream=color.r`;
            const tab = await browser.page(`${lights}&integrator=shadows&device=${device}`);
            const pictures = [];
            for (const integrator of ["shadows", null]) {
                const seen = integrator ? await tab.settled() : await tab.go(`${lights}&device=${device}`);
                assert.deepEqual([keyOf(seen.link, "integrator"), seen.error], [integrator, ""]);
                const download = tab.page.waitForEvent("download");
                await tab.perform("Export stream as npy");
                pictures.push(floats(readFileSync(await (await download).path())));
                await tab.screenshot(`${way}-light-${integrator ?? "local"}`);
            }
            const [shadows, local] = pictures;
            assert.ok(shadows.length >= 3 * 48 * 40 && shadows.length === local.length, `${shadows.length} floats`);
            assert.ok(shadows.every((value, i) => value <= local[i] * (1 + 1e-5)), "shadows take light away");
            const darker = shadows.filter((value, i) => value < 0.5 * local[i]).length;
            assert.ok(darker > 100 && darker < shadows.length / 2, `${darker} of ${shadows.length} are darker`);
            // What the desktop computes; a few pixels at the edges of shadows may differ by device.
            const folder = mkdtempSync(path.join(tmpdir(), "raystep-light-"));
            const words = ["--integrator", "shadows", "--schedule", "second", "--size", "48x40", "--device", "cpu", "--pass", "last"];
            execFileSync(process.env.RAYSTEP, ["dump", path.join(scenes, "cornell-box.gltf"), "-o", `${folder}/d`, ...words], { stdio: "pipe" });
            const name = readdirSync(`${folder}/d`).find((name) => name.endsWith(".color.npy"));
            const expected = floats(readFileSync(`${folder}/d/${name}`));
            const differ = shadows.filter((value, i) => Math.abs(value - expected[i]) > 1e-4).length;
            assert.ok(expected.length === shadows.length && differ <= (device === "cpu" ? 0 : 12), `${differ} differ`);
            assert.deepEqual(tab.troubles, []);
            await tab.page.close();
        });

        test("a dropped scene is opened, with its files; a broken one is refused", async () => {
            const tab = await browser.page(SMALL);
            await tab.settled();
            const file = (name) => [name, readFileSync(path.join(scenes, name))];
            await tab.drop([file("textures.gltf"), file("textures-данные.bin"), file("schach brett ü.png")]);
            let { link, error } = await tab.settled();
            assert.deepEqual([keyOf(link, "scene"), error], ["textures.gltf", ""]);
            await tab.drop([["broken.glb", readFileSync(path.join(scenes, "teapot.glb")).subarray(0, 4000)]]);
            ({ link, error } = await tab.settled());
            assert.match(error, /broken\.glb: /);
            assert.equal(keyOf(link, "scene"), "textures.gltf", "the open scene stays");
            assert.deepEqual(tab.troubles, []);
            await tab.page.close();
        });

        test("a dropped kernel takes the place of the built-in one; one that is wrong or does not end does no harm", async () => {
            const tab = await browser.page(`${SMALL}&device=${device}&stream=color.r`);
            await tab.settled();
            const picture = async () => {
                const download = tab.page.waitForEvent("download");
                await tab.perform("Export stream as npy");
                return floats(readFileSync(await (await download).path()));
            };
            const own = readFileSync(path.join(scenes, "../kernels/src/programs/closest_hit/intersect.wgsl"), "utf8");
            // The file is read aside, so the page may be calm for a moment before anything comes of it.
            const drop = async (from, to, wanted) => {
                assert.ok(own.includes(from), from);
                await tab.drop([["my.wgsl", own.replace(from, to)]]);
                let error = "";
                for (let turn = 0; turn < 100 && !wanted.test(error); turn++) {
                    await tab.page.waitForTimeout(100);
                    ({ error } = await tab.settled());
                }
                assert.match(error, wanted);
            };
            const [hit, fewer] = ["candidate.is_hit && accepted", "candidate.is_hit && accepted && entry.triangle > 3u"];
            const before = await picture();
            await drop(hit, fewer, /^$/);
            let after = before;
            const differ = () => after.filter((value, i) => value !== before[i]).length;
            for (let turn = 0; turn < 20 && differ() === 0; turn++) {
                after = await picture();
            }
            assert.ok(differ() > 100 && after.length === before.length, `${differ()} of ${after.length} differ`);
            await tab.screenshot(`${way}-own-kernel`);
            const line = own.slice(0, own.indexOf("item += 1u;")).split("\n").length;
            await drop("item += 1u;", "item += one;", new RegExp(`^my\\.wgsl:${line}:17: no definition in scope`));
            const loop = "    var n = 1u; while (n > 0u) { n ^= 2u; }\n    let ray = load_ray(texel);";
            await drop("    let ray = load_ray(texel);", loop, /my\.wgsl:\d+: a loop has not ended after \d+ turns/);
            // The version before is still there, on the same device.
            assert.deepEqual(await picture(), after);
            assert.deepEqual(tab.troubles, []);
            await tab.page.close();
        });

        test("exports are downloads", async () => {
            const tab = await browser.page(`${SMALL}&device=${device}`);
            await tab.settled();
            const download = tab.page.waitForEvent("download");
            await tab.perform("Export pass timings as CSV");
            const file = await download;
            assert.match(file.suggestedFilename(), /^cornell-box.*\.csv$/);
            const lines = readFileSync(await file.path(), "utf8").trim().split("\n").filter((line) => !line.startsWith("#"));
            assert.equal(lines.length, 1 + (await tab.state()).place, "a header, and a row per pass");
            await tab.page.close();
        });

        test("a reload in the middle of a run, a hidden tab and a second one do no harm", async () => {
            const tab = await browser.page(`${SMALL}&device=${device}&pass=0`);
            await tab.settled();
            await tab.page.keyboard.press("End");
            await tab.page.reload();
            await tab.settled();
            const other = await browser.page(`${SMALL}&device=${device}`);
            await tab.page.keyboard.press("End");
            await other.settled();
            await other.page.close();
            await tab.page.bringToFront();
            await tab.settled();
            await tab.page.setViewportSize({ width: 700, height: 500 });
            const { error } = await tab.settled();
            await tab.screenshot(`${way}-small`);
            assert.equal(error, "");
            assert.deepEqual(tab.troubles, []);
            await tab.page.close();
        });

        test("a lost device is said, and the run resumes at the same place", async () => {
            const tab = await browser.page(`${SMALL}&device=${device}&pass=20&pixel=40,50`);
            const { link } = await tab.settled();
            const session = await browser.chromium.newBrowserCDPSession();
            // It does not answer, as the process that would is gone.
            session.send("Browser.crashGpuProcess").catch(() => {});
            await tab.page.waitForFunction(() => window.raystep.failure !== undefined);
            assert.match(await tab.page.textContent("#message"), /lost|took back/);
            assert.deepEqual(await unreadable(tab.page), []);
            await tab.page.click("#buttons button");
            // The page is loaded again.
            await tab.page.waitForFunction(() => window.raystep?.isReady);
            const state = await tab.settled();
            assert.deepEqual([state.link, state.error], [link, ""]);
            await tab.page.close();
        });
    });
}

/// The floats of a file of numpy, whose header says how long it is.
function floats(file) {
    const begin = 10 + file.readUInt16LE(8);
    return Array.from({ length: (file.length - begin) / 4 }, (_, i) => file.readFloatLE(begin + 4 * i));
}

/// In the page: presses a key, and waits until another place is shown: for the worker's frame, and then for the display's next
/// two, which come once that was drawn. Milliseconds.
function stepped(key) {
    const [name, ...modifiers] = key.split("+").reverse();
    const begin = performance.now();
    const before = window.raystep.place;
    const canvas = document.getElementById("canvas");
    const init = { key: name, code: name, shiftKey: modifiers.includes("Shift"), bubbles: true, cancelable: true };
    canvas.dispatchEvent(new KeyboardEvent("keydown", init));
    canvas.dispatchEvent(new KeyboardEvent("keyup", init));
    return new Promise((resolve) => {
        const look = () => {
            if (window.raystep.place !== before) {
                requestAnimationFrame(() => requestAnimationFrame(() => resolve(performance.now() - begin)));
            } else {
                setTimeout(look, 1);
            }
        };
        look();
    });
}

test("without WebGPU, WebGL 2 draws kernels: exported streams are those of the CPU", async () => {
    const browser = await Browser.open("webgl");
    const shown = {};
    for (const device of ["gpu", "cpu"]) {
        const tab = await browser.page(`${SMALL}&schedule=second&device=${device}&pixel=40,50`);
        const begin = Date.now();
        const { link, place, error, device: name } = await tab.settled();
        console.log(`${device}: ${place} passes in ${Date.now() - begin} ms on ${name}`);
        assert.equal(error, "");
        assert.deepEqual(
            [keyOf(link, "mapping"), keyOf(link, "scene-data"), keyOf(link, "device")],
            device === "gpu" ? ["fragment", "textures", "gpu"] : [null, null, "cpu"],
        );
        assert.match(name, device === "gpu" ? /WebGL 2$/ : /^CPU, f32$/);
        const files = [];
        const take = async (command) => {
            const download = tab.page.waitForEvent("download");
            await tab.perform(command);
            files.push(readFileSync(await (await download).path()).toString("base64"));
        };
        await take("Export stream as npy");
        const places = [];
        for (const key of ["Shift+F10", "Home", "F10", "F10", "F10"]) {
            const seen = await tab.press(key);
            assert.equal(seen.error, "");
            places.push(seen.place);
        }
        // What ends a loop is known a pass later than by counts, so that a run has some passes more.
        assert.equal(places.shift(), place - 1);
        await take("Export stream as npy");
        await tab.screenshot(`webgl-drawn-${device}`);
        shown[device] = { places, files };
        assert.deepEqual(tab.troubles, []);
        await tab.page.close();
    }
    assert.deepEqual(shown.gpu.places, shown.cpu.places);
    assert.deepEqual(
        shown.gpu.files.map((file, i) => file === shown.cpu.files[i]),
        [true, true],
    );
    await browser.close();
});

test("without anything to draw with, the page says so, and shows pictures", async () => {
    const browser = await Browser.open("nothing");
    const tab = await browser.page();
    await assert.rejects(tab.ready(), /WebGL/);
    await tab.page.waitForFunction(() => [...document.images].length === 3 && [...document.images].every((i) => i.naturalWidth > 0));
    assert.match(await tab.page.textContent("#message"), /cannot run in this browser/);
    await tab.screenshot("nothing");
    assert.deepEqual(await unreadable(tab.page), []);
    // The lessons as a page.
    await tab.page.goto(new URL("lessons.html", tab.page.url()).href);
    assert.deepEqual(await unreadable(tab.page), []);
    await browser.close();
});
