// Hits by WebGPU and by WebGL 2 against the CPU reference kernels, in the page and on the desktop, on scenes of the
// repository, with every structure and schedule.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readdirSync, readFileSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";
import { test } from "node:test";

import { Browser, scenes } from "./browser.mjs";

const STRUCTURES = ["grid", "irregular", "bvh", "none"];
const SCHEDULES = ["first", "second", "compact", "fused"];
const SIDE = 32;
const WORDS = 5;

/// In a page: imports the module without an inspector.
async function begin() {
    const module = await import("/raystep_web.js");
    self.raystep = {
        now: () => performance.now(),
        later: () => setTimeout(module.work),
        fetch: async (url) => {
            const response = await fetch(`/${url}`);
            if (!response.ok) {
                throw new Error(`${url}: ${response.status}`);
            }
            return new Uint8Array(await response.arrayBuffer());
        },
        ask_for: () => {},
    };
    const compressed = await fetch("/raystep_web_bg.wasm.gz");
    const bytes = compressed.body.pipeThrough(new DecompressionStream("gzip"));
    await module.default({ module_or_path: new Response(bytes, { headers: { "content-type": "application/wasm" } }) });
    [self.hits, self.adapters] = [module.hits, module.adapters];
}

const WAYS = STRUCTURES.flatMap((structure) => SCHEDULES.map((schedule) => `&accelerator=${structure}&schedule=${schedule}`));
/// Every scene in every way; otherwise two ways a scene, and every way on some scene.
const IS_THOROUGH = Boolean(process.env.RAYSTEP_THOROUGH);
/// A software driver may not stand hundreds of pipelines in one process.
const RUNS_A_PROCESS = 16;

/// The hits of the desktop's reference kernels, by the program that RAYSTEP_HITS names.
function onDesktop(links) {
    const folder = mkdtempSync(path.join(tmpdir(), "raystep-hits-"));
    const [from, to] = ["links", "words"].map((name) => path.join(folder, name));
    writeFileSync(from, links.join("\n"));
    execFileSync(process.env.RAYSTEP_HITS, [from, to]);
    const bytes = readFileSync(to);
    return new Uint32Array(bytes.buffer, bytes.byteOffset, bytes.length / 4);
}

/// Compares hits of links, on these devices of a page that draws in a way, with those of the desktop's reference kernels.
/// `mapped` is added to the links of a GPU.
async function compare(way, links, devices, mapped = "") {
    const words = WORDS * SIDE * SIDE;
    const expected = onDesktop(links);
    assert.equal(expected.length, links.length * words);
    const differing = Object.fromEntries(devices.map((device) => [device, 0]));
    const wrong = [];
    for (let first = 0; first < links.length; first += RUNS_A_PROCESS) {
        const browser = await Browser.open(way);
        const page = await browser.chromium.newPage();
        // Not the inspector's page: nothing runs there.
        await page.goto(`http://localhost:${browser.server.address().port}/style.css`);
        await page.evaluate(begin);
        assert.equal((await page.evaluate(() => self.adapters())).length, way === "webgpu" ? 1 : 0);
        for (let at = first; at < Math.min(first + RUNS_A_PROCESS, links.length); at += 1) {
            const desktop = expected.subarray(at * words, (at + 1) * words);
            for (const device of devices) {
                const isOnGpu = device === "gpu";
                const found = await page.evaluate(
                    async ([link, isOnGpu]) => Array.from(await self.hits(link, isOnGpu)),
                    [isOnGpu ? links[at] + mapped : links[at], isOnGpu],
                );
                assert.equal(found.length, words, links[at]);
                for (let ray = 0; ray < words; ray += WORDS) {
                    const isSame = [...Array(WORDS).keys()].every((word) => found[ray + word] === desktop[ray + word]);
                    differing[device] += isSame ? 0 : 1;
                    if (found[ray] !== desktop[ray]) {
                        wrong.push(`${links[at]}, ${device}: ray ${ray / WORDS} hits ${found[ray]}, not ${desktop[ray]}`);
                    }
                }
            }
        }
        await browser.close();
    }
    const rays = links.length * SIDE * SIDE;
    console.log(
        `${way}: ${links.length} pictures, ${rays} rays; ${JSON.stringify(differing)} differ in some bit from the desktop's, ` +
            `${wrong.length} in their triangle`,
    );
    // This software driver neither contracts products and sums nor divides less exactly than a CPU.
    assert.deepEqual([Object.values(differing), wrong], [devices.map(() => 0), []]);
}

const linkOf = (name, way) => `raystep:1?scene=${encodeURIComponent(name)}&size=${SIDE}x${SIDE}${way}`;
const names = readdirSync(scenes).filter((name) => /\.gl(tf|b)$/.test(name));

test("WebGPU, and the reference kernels in the page, hit what the reference kernels hit on the desktop", async () => {
    const taken = (way, scene) => IS_THOROUGH || way % names.length === scene || (way + 7) % WAYS.length === scene;
    const links = names.flatMap((name, scene) =>
        WAYS.filter((_, way) => taken(way, scene)).map((way) => linkOf(name, way)),
    );
    await compare("webgpu", links, ["gpu", "cpu"]);
});

test("fragment programs of WebGL 2 hit what the reference kernels hit on the desktop", async () => {
    const ways = WAYS.filter((way) => /first|second/.test(way));
    // A pass a triangle, without a structure.
    const isShort = (name, way) => name === "cornell-box.gltf" || !/none/.test(way);
    const taken = (name) => IS_THOROUGH || ["cornell-box.gltf", "lights.gltf"].includes(name);
    const links = names.filter(taken).flatMap((name) =>
        ways.filter((way) => isShort(name, way)).map((way) => linkOf(name, way)),
    );
    await compare("webgl", links, ["gpu"], "&mapping=fragment&scene-data=textures");
});
