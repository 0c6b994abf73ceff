// What a page must stand: broken and large scenes, thousands of steps, slow and zoomed displays; exports as on the desktop.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readdirSync, readFileSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";
import { after, before, test } from "node:test";

import { Browser, keyOf, scenes } from "./browser.mjs";

const TINY = "raystep:1?scene=scenes/cornell-box.gltf&size=32x32&device=cpu";

let browser;
before(async () => {
    browser = await Browser.open("webgl");
});
after(() => browser.close());

/// Numbers that are the same in every run (Marsaglia 2003, xorshift).
function random(seed) {
    let state = seed;
    return (below) => {
        state ^= state << 13;
        state ^= state >>> 17;
        state ^= state << 5;
        return (state >>> 0) % below;
    };
}

/// The loader's corpus, and scenes of the repository with bytes changed or cut off.
function broken() {
    const corpus = path.join(scenes, "fuzz/corpus/load");
    const names = readdirSync(corpus).filter((name) => /\.gl(tf|b)$/.test(name));
    const files = names.map((name) => [name, readFileSync(path.join(corpus, name))]);
    const below = random(2026);
    for (const name of ["teapot.glb", "quantized.glb", "instances.gltf", "skin-and-morph.gltf"]) {
        const whole = readFileSync(path.join(scenes, name));
        for (let i = 0; i < 4; i += 1) {
            const bytes = Buffer.from(i % 2 === 0 ? whole : whole.subarray(0, below(whole.length)));
            // In the part that describes the rest.
            for (let change = 0; change < 4; change += 1) {
                bytes[below(Math.min(bytes.length, 2000))] = below(256);
            }
            files.push([`broken-${i}-${name}`, bytes]);
        }
    }
    const accessor = { componentType: 5126, type: "VEC3", bufferView: 0 };
    const wrong = {
        count: { accessors: [{ ...accessor, count: 4_294_967_295 }] },
        offset: { accessors: [{ ...accessor, count: 3, byteOffset: 18_446_744_073_709_551_615 }] },
        cycle: { nodes: [{ children: [0], mesh: 0 }], scenes: [{ nodes: [0] }], accessors: [{ ...accessor, count: 3 }] },
        buffer: { buffers: [{ byteLength: 1e15, uri: "data:application/octet-stream;base64,AAAA" }] },
    };
    for (const [name, parts] of Object.entries(wrong)) {
        const scene = {
            asset: { version: "2.0" },
            buffers: [{ byteLength: 36, uri: `data:application/octet-stream;base64,${Buffer.alloc(36).toString("base64")}` }],
            bufferViews: [{ buffer: 0, byteLength: 36 }],
            meshes: [{ primitives: [{ attributes: { POSITION: 0 } }] }],
            nodes: [{ mesh: 0 }],
            scenes: [{ nodes: [0] }],
            scene: 0,
            ...parts,
        };
        files.push([`${name}.gltf`, Buffer.from(JSON.stringify(scene))]);
    }
    files.push(["deep.gltf", Buffer.from("[".repeat(200_000))]);
    return files;
}

test("no broken scene stops the page", async () => {
    const tab = await browser.page(TINY);
    await tab.settled();
    let refused = 0;
    const files = broken();
    for (const file of files) {
        await tab.drop([file]);
        const { error, link } = await tab.settled();
        if (keyOf(link, "scene") !== file[0]) {
            assert.ok(error.includes(file[0]), `${file[0]}: ${error}`);
            refused += 1;
        }
    }
    console.log(`${files.length} scenes, ${refused} refused`);
    assert.ok(refused > files.length / 2, "most are broken");
    const { link } = await tab.go(TINY);
    assert.equal(keyOf(link, "scene"), "scenes/cornell-box.gltf");
    assert.deepEqual(tab.troubles, []);
    await tab.page.close();
});

/// In the page: drops a GLB of triangles that are scattered over a square.
function dropLarge(triangles) {
    const corners = new Float32Array(9 * triangles);
    let state = 1;
    const random = () => (state = (Math.imul(state, 1_664_525) + 1_013_904_223) >>> 0) / 4_294_967_296;
    for (let at = 0; at < corners.length; at += 9) {
        const [x, y, z] = [random(), random(), 0.1 * random()];
        corners.set([x, y, z, x + 0.002, y, z, x, y + 0.002, z], at);
    }
    const bytes = corners.byteLength;
    const json = JSON.stringify({
        asset: { version: "2.0" },
        scene: 0,
        scenes: [{ nodes: [0] }],
        nodes: [{ mesh: 0 }],
        meshes: [{ primitives: [{ attributes: { POSITION: 0 } }] }],
        accessors: [{ bufferView: 0, componentType: 5126, count: 3 * triangles, type: "VEC3", min: [0, 0, 0], max: [1.1, 1.1, 0.1] }],
        bufferViews: [{ buffer: 0, byteLength: bytes }],
        buffers: [{ byteLength: bytes }],
    });
    const text = new TextEncoder().encode(json.padEnd(Math.ceil(json.length / 4) * 4));
    const words = (...values) => new Uint32Array(values);
    const parts = [
        words(0x46546c67, 2, 12 + 8 + text.length + 8 + bytes),
        words(text.length, 0x4e4f534a),
        text,
        words(bytes, 0x004e4942),
        corners,
    ];
    const transfer = new DataTransfer();
    transfer.items.add(new File(parts, "large.glb"));
    document.dispatchEvent(new DragEvent("drop", { dataTransfer: transfer, cancelable: true, bubbles: true }));
    return bytes;
}

test("a scene of 80 MB is opened, while the page answers", async () => {
    const tab = await browser.page(TINY);
    await tab.settled();
    assert.ok((await tab.page.evaluate(dropLarge, 2_300_000)) > 80e6);
    const begin = Date.now();
    const opened = tab.page.evaluate(async () => {
        for (;;) {
            const { link, error, busy } = await window.raystep.state();
            if (error || window.raystep.failure || (link.includes("large.glb") && !busy)) {
                return;
            }
            await new Promise((resolve) => setTimeout(resolve, 100));
        }
    });
    let isOpen = false;
    opened.finally(() => (isOpen = true));
    let slowest = 0;
    while (!isOpen) {
        const asked = Date.now();
        await tab.page.evaluate(() => document.title);
        slowest = Math.max(slowest, Date.now() - asked);
        await tab.page.waitForTimeout(50);
    }
    await opened;
    const { link, error, bytes } = await tab.settled();
    assert.deepEqual([keyOf(link, "scene"), error], ["large.glb", ""]);
    console.log(`80 MB: open after ${((Date.now() - begin) / 1000).toFixed(1)} s, ${Math.round(bytes / 2 ** 20)} MiB of memory, ` +
        `the page answers within ${slowest} ms`);
    // It has nothing else to do; the machine has.
    assert.ok(slowest < 2000);
    await tab.screenshot("large");
    assert.deepEqual(tab.troubles, []);
    await tab.page.close();
});

/// Passes over which memory must not grow: as many take minutes.
const PASSES = process.env.RAYSTEP_THOROUGH ? 10_000 : 2_000;

test("memory stays the same over thousands of passes, forwards and back", async () => {
    const tab = await browser.page(TINY);
    const end = (await tab.settled()).place;
    const memory = async () => [(await tab.state()).bytes, await tab.page.evaluate(() => performance.memory.usedJSHeapSize)];
    const session = await tab.page.context().newCDPSession(tab.page);
    const collected = async () => {
        await session.send("HeapProfiler.collectGarbage");
        return memory();
    };
    const round = async () => {
        for (const [key, place] of [
            ["Home", 0],
            ["End", end],
        ]) {
            await tab.page.keyboard.press(key);
            await tab.page.waitForFunction((place) => window.raystep.place === place && !window.raystep.isBusy, place, { polling: 5 });
        }
    };
    for (let i = 0; i < 10; i += 1) {
        await round();
    }
    const before = await collected();
    for (let passes = 0; passes < PASSES; passes += end) {
        await round();
    }
    await tab.settled();
    const after = await collected();
    console.log(`${PASSES} passes: ${before} bytes before, ${after} after`);
    // What the module takes it never gives back: a page of 64 KiB may be taken for the largest of many frames.
    assert.ok(after[0] - before[0] <= 2 ** 20);
    assert.ok(after[1] - before[1] < 2 ** 20);
    assert.deepEqual(tab.troubles, []);
    await tab.page.close();
});

test("a slow processor, and other zooms, change nothing but the speed", async () => {
    const tab = await browser.page(`${TINY}&pass=0`);
    await tab.settled();
    const session = await tab.page.context().newCDPSession(tab.page);
    await session.send("Emulation.setCPUThrottlingRate", { rate: 6 });
    assert.equal((await tab.press("F10", "F10", "F10")).place, 3);
    await session.send("Emulation.setCPUThrottlingRate", { rate: 1 });
    for (const scale of [0.5, 1.5, 3]) {
        const metrics = { width: Math.round(1280 / scale), height: Math.round(800 / scale), deviceScaleFactor: scale, mobile: false };
        await session.send("Emulation.setDeviceMetricsOverride", metrics);
        await tab.page.waitForFunction((scale) => window.devicePixelRatio === scale, scale);
        const { place, error, size } = await tab.press("F10");
        assert.deepEqual([error, size], ["", [metrics.width * scale, metrics.height * scale].map(Math.round)]);
        assert.ok(place > 3);
        await tab.screenshot(`zoom-${scale}`);
    }
    assert.deepEqual(tab.troubles, []);
    await tab.page.close();
});

test("exported streams have the bytes of the desktop's", async () => {
    const folder = mkdtempSync(path.join(tmpdir(), "raystep-dump-"));
    // After 12 passes: the last of them is number 11.
    const tab = await browser.page(`${TINY}&pass=12&stream=tmax`);
    await tab.settled();
    for (const [name, format] of [
        ["Export stream as npy", "npy"],
        ["Export stream as EXR", "exr"],
    ]) {
        const download = tab.page.waitForEvent("download");
        await tab.perform(name);
        const file = await download;
        const dump = ["dump", path.join(scenes, "cornell-box.gltf"), "--size", "32x32", "--device", "cpu", "--pass", "11"];
        execFileSync(process.env.RAYSTEP, [...dump, "--stream", "tmax", "--format", format, "-o", path.join(folder, format), "--quiet"]);
        const [written] = readdirSync(path.join(folder, format)).filter((name) => name.endsWith(`.${format}`));
        const [page, desktop] = [readFileSync(await file.path()), readFileSync(path.join(folder, format, written))];
        assert.ok(page.equals(desktop), `${file.suggestedFilename()} (${page.length} bytes) is not ${written} (${desktop.length})`);
    }
    await tab.page.close();
});
