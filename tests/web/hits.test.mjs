// Hits by WebGPU against the CPU reference kernels, on every scene of the repository, with every structure and schedule.

import assert from "node:assert/strict";
import { readdirSync } from "node:fs";
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
    self.hits = module.hits;
}

const WAYS = STRUCTURES.flatMap((structure) => SCHEDULES.map((schedule) => `&accelerator=${structure}&schedule=${schedule}`));
/// Every scene in every way; otherwise two ways a scene, and every way on some scene.
const IS_THOROUGH = Boolean(process.env.RAYSTEP_THOROUGH);
/// A software driver may not stand hundreds of pipelines in one process.
const RUNS_A_PROCESS = 16;

test("WebGPU hits what the CPU reference kernels hit", async () => {
    const names = readdirSync(scenes).filter((name) => /\.gl(tf|b)$/.test(name));
    const taken = (way, scene) => IS_THOROUGH || way % names.length === scene || (way + 7) % WAYS.length === scene;
    const links = names.flatMap((name, scene) =>
        WAYS.filter((_, way) => taken(way, scene)).map(
            (way) => `raystep:1?scene=${encodeURIComponent(name)}&size=${SIDE}x${SIDE}${way}`,
        ),
    );
    let differing = 0;
    const wrong = [];
    for (let first = 0; first < links.length; first += RUNS_A_PROCESS) {
        const browser = await Browser.open("webgpu");
        const page = await browser.chromium.newPage();
        // Not the inspector's page: nothing runs there.
        await page.goto(`http://localhost:${browser.server.address().port}/style.css`);
        await page.evaluate(begin);
        for (const link of links.slice(first, first + RUNS_A_PROCESS)) {
            const [gpu, cpu] = await page.evaluate(
                async (link) => [Array.from(await self.hits(link, true)), Array.from(await self.hits(link, false))],
                link,
            );
            assert.equal(gpu.length, WORDS * SIDE * SIDE, link);
            for (let ray = 0; ray < gpu.length; ray += WORDS) {
                const words = [...Array(WORDS).keys()].map((word) => ray + word);
                differing += words.some((word) => gpu[word] !== cpu[word]) ? 1 : 0;
                if (gpu[ray] !== cpu[ray]) {
                    wrong.push(`${link}: ray ${ray / WORDS} hits ${gpu[ray]}, not ${cpu[ray]}`);
                }
            }
        }
        await browser.close();
    }
    const rays = links.length * SIDE * SIDE;
    console.log(`${links.length} pictures, ${rays} rays: ${differing} differ in some bit, ${wrong.length} in their triangle`);
    // This software driver neither contracts products and sums nor divides less exactly than a CPU.
    assert.deepEqual([differing, wrong], [0, []]);
});
