// Typical mistakes in a kernel that is dropped on the page: each is named with its place, or with the first value that is
// wrong; and the kernel dropped next leaves the same picture, on the same device.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import path from "node:path";
import { after, before, describe, test } from "node:test";

import { Browser, keyOf, scenes } from "./browser.mjs";

const LINK = "raystep:1?scene=scenes/cornell-box.gltf&size=16x16&stream=color.r";
const BUILT_IN = readFileSync(path.join(scenes, "../kernels/src/programs/closest_hit/intersect.wgsl"), "utf8");
/// Shows where a mistake is expected; removed before the file is dropped.
const HERE = "‸";

/// Where another declaration can stand, and where it can be used.
const ABOVE = "fn step_item(";
const LIST = "    let list = list_of(cell);";
const HIT = "@group(0) @binding(3) var hit: texture_storage_2d_array<r32uint, read_write>;\n";
const ITEM = "textureStore(state, texel, 3, vec4u(item))";
const NEARER = "is_nearer(candidate.t, entry.triangle, nearest_t, textureLoad(hit, texel, 2).x)";

/// Name, texts with those that take their places, and the message that is found without a run.
const REFUSED = [
    [
        "missing-binding",
        [[HIT, ""], ["entry.triangle, nearest_t, textureLoad(hit,", "entry.triangle, nearest_t, textureLoad(‸hit,"]],
        "no definition in scope for identifier: `hit`",
    ],
    ["doubled-binding", [["@binding(3) var hit", "@binding(2) ‸var hit"]], "hit and state have the same @group(0) @binding(2)"],
    ["wrong-type", [["let cell = ", "let ‸cell: f32 = "]], "the type of `cell` is expected to be `f32`, but got `u32`"],
    [
        "wrong-stream",
        [["hit: texture_storage_2d_array<r32uint", "hit: texture_storage_2d_array<r32float"], ["0, vec4u(", "0, ‸vec4u("]],
        "cannot convert elements of `vec4<u32>` to `f32`",
    ],
    [
        "address-space",
        [[ABOVE, `@group(1) @binding(30) ‸var<storage, read_write> materials: array<u32>;\n${ABOVE}`], [LIST, `    materials[0] = 1u;\n${LIST}`]],
        "the buffer materials is var<storage, read>: a kernel only reads it",
    ],
    ["recursion", [[ABOVE, "fn ‸step_item("], [LIST, `    _ = step_item(texel);\n${LIST}`]], "declaration of `step_item` is recursive"],
    ["name-clash", [[ABOVE, `fn ‸load_ray(texel: vec2u) -> u32 {\n    return 0u;\n}\n${ABOVE}`]], "load_ray is declared here, and in package::ray"],
    ["declared-twice", [[ABOVE, "fn step_item() {}\nfn ‸step_item("]], "step_item is declared twice in this file"],
    ["uniformity", [["    send(lane", "    if (lane < 8u) { return; }\n    ‸send(lane"]], "some threads of a workgroup may not reach this"],
    ["unknown-name", [["has_item(list, item)", "‸hasitem(list, item)"]], "no definition in scope for identifier: `hasitem`"],
    ["unknown-module", [["package::corners::", "package::‸corner::"]], "no module is named package::corner"],
    ["no-semicolon", [["texel, 3).x;\n", "texel, 3).x\n"], ["    let list =", "    ‸let list ="]], "expected `;`"],
    ["no-return", [["return tag;\n}\n\n@compute", "}\n\n@compute"], [ABOVE, "‸fn step_item("]], "a way through step_item ends without a return"],
    ["arguments", [["load_ray(texel)", "‸load_ray(texel, 1u)"]], "Requires 1 arguments, but 2 are provided"],
    [
        "workgroup-size",
        [["@workgroup_size(LIST_SIDE, LIST_SIDE)\nfn ", "@workgroup_size(64)\nfn ‸"]],
        "its workgroups have 64×1×1 threads, but intersect is launched with @workgroup_size(16, 16)",
    ],
    [
        "not-sent",
        [["send(lane, texel, step_item(texel))", "_ = step_item(texel)"], ["fn intersect(", "fn ‸intersect("]],
        "it does not tell where its elements go",
    ],
    // No line is to blame.
    ["entry-point", [["fn intersect(", "fn mine("]], "no kernel is named mine"],
];

/// What a run finds. A device reads another element, stores to a neighbour and goes on: it is found by comparison.
const LOOP = "    var n = 1u;\n    ‸while (n > 0u) { n ^= 2u; }\n";
const ENDLESS = ["endless-loop", [[LIST, `${LOOP}${LIST}`]], "a loop has not ended after 1048576 turns"];
const OUTSIDE = ["out-of-range", [[LIST, LIST.replace("let list = list_of(cell)", "‸let list = list_of(cell + 100000u)")]]];
const RACE = ["race", [[ITEM, `‸${ITEM.replace("texel", "texel + vec2u(1u, 0u)")}`]]];

/// What differs first: stream and layer, value, and what is expected.
const WRONG = [
    ["off-by-one", [["item += 1u", "item += 2u"]], "state.item", "2", "1"],
    // After the end of an empty list.
    ["less-or-equal", [["has_item(list, item)", "(item <= list.count)"]], "state.item", "1", "0"],
    ["forgotten-store", [[`    ${ITEM};\n`, ""]], "state.item", "0", "1"],
    ["swapped", [["candidate.u", "candidate.w"], ["candidate.v", "candidate.u"], ["candidate.w", "candidate.v"]], "hit.u"],
    ["wrong-state", [["tag = ISECT_HIT;", "tag = SHADE;"]], "state.tag"],
];

/// A kernel's text with a mistake, and its line and column, from 1, if there is a mark.
function edited(edits) {
    const marked = edits.reduce((text, [from, to]) => {
        assert.ok(text.includes(from), `no ${from}`);
        return text.replace(from, () => to);
    }, BUILT_IN);
    const lines = marked.split("\n");
    const line = lines.findIndex((text) => text.includes(HERE));
    return { source: marked.replace(HERE, ""), line: line + 1, column: line < 0 ? 0 : lines[line].indexOf(HERE) + 1 };
}

/// A page that shows the panel Divergence, in a small window, which is drawn quickly.
class Bench {
    drops = 0;

    static async open(browser, device) {
        const own = new Bench();
        own.tab = await browser.page(`${LINK}&device=${device}`);
        own.page = own.tab.page;
        await own.page.setViewportSize({ width: 700, height: 420 });
        await own.tab.settled();
        await own.page.evaluate(observe);
        await own.tab.perform("Divergence");
        await own.tab.press("F12");
        own.picture = await own.exported();
        return own;
    }

    /// Acts, and waits until nothing is left to draw, or for three frames: messages move until they fade, and a dialog takes
    /// texts from its second frame on.
    async frame(act) {
        await act();
        await this.page.evaluate(async () => {
            await window.raystep.state();
            const { frames } = window.raystep;
            while (window.raystep.frames < frames + 3 && (await window.raystep.state()).busy) {
                await new Promise((resolve) => setTimeout(resolve, 5));
            }
        });
    }

    /// Begins something, and waits until nothing is left to do: `settled` would also wait until messages fade.
    async done(begin) {
        await this.page.evaluate(() => (window.observed.wasBusy = false));
        await begin();
        await this.page.waitForFunction(() => window.observed.wasBusy, null, { timeout: 60_000, polling: 20 });
        for (let calm = 0; ; ) {
            const state = await this.tab.state();
            calm = (await this.page.evaluate(() => window.raystep.isBusy)) ? 0 : calm + 1;
            if (calm === 4) {
                return state;
            }
            await this.page.waitForTimeout(40);
        }
    }

    /// Drops a kernel, which is another one than before: the same again would change nothing.
    drop(name, source) {
        this.drops += 1;
        return this.done(() => this.tab.drop([[name, `${source}// ${this.drops}\n`]]));
    }

    /// Drops a kernel with a mistake, and waits for its message.
    async refused([name, edits, message], isComposed) {
        const { source, line, column } = edited(edits);
        let { error } = await this.drop(`${name}.wgsl`, source);
        for (let turn = 0; turn < 100 && !error.includes(`${name}.wgsl`); turn++) {
            await this.page.waitForTimeout(50);
            ({ error } = await this.tab.state());
        }
        const place = line === 0 ? "" : `:${line}${isComposed ? `:${column}` : ""}`;
        const isNamed = line === 0 || error.startsWith(name);
        assert.ok(isNamed && error.includes(`${name}.wgsl${place}: `) && error.includes(message), `${error}: not ${place} ${message}`);
        return error;
    }

    /// The exported picture, byte by byte.
    async exported() {
        await this.page.evaluate(() => window.observed.saved.splice(0));
        await this.frame(() => this.page.keyboard.press("Control+p"));
        await this.frame(() => this.page.keyboard.type("Export stream as npy"));
        await this.frame(() => this.page.keyboard.press("Enter"));
        await this.page.waitForFunction(() => window.observed.saved.length > 0, null, { timeout: 30_000, polling: 20 });
        return this.page.evaluate(async () => Array.from(new Uint8Array(await window.observed.saved[0].arrayBuffer())).join());
    }

    /// Drops the built-in kernel as the user's: the picture is the first one.
    async mended(label) {
        await this.drop("good.wgsl", BUILT_IN);
        // The last passes may be drawn a moment later.
        let isSame = false;
        for (let turn = 0; turn < 5 && !isSame; turn++) {
            isSame = (await this.exported()) === this.picture;
        }
        assert.ok(isSame, `${label}: another picture`);
        assert.equal(await this.page.evaluate(() => window.raystep.failure), undefined, label);
    }

    /// What the panel says of the comparison with the built-in kernel: selected with the mouse, and copied.
    async compared() {
        await this.done(() => this.page.keyboard.press("Control+d"));
        // Where its first line is depends on what else is said above.
        for (const top of [150, 125, 137, 162, 175]) {
            const move = (x, y) => this.frame(() => this.page.mouse.move(x, y));
            await move(7, top);
            await this.frame(() => this.page.mouse.down());
            // Below the last line, so that it is selected to its end.
            await move(400, top + 60);
            await this.frame(() => this.page.mouse.up());
            await this.page.evaluate(() => window.observed.copied.splice(0));
            await this.frame(() => this.page.keyboard.press("Control+c"));
            const [text] = await this.page.evaluate(() => window.observed.copied);
            if (/ray/.test(text ?? "")) {
                return text;
            }
        }
        throw new Error("no comparison is shown");
    }

    /// Drops a kernel that leaves other values, and asserts the first.
    async differs([name, edits, component, value, expected]) {
        const { error } = await this.drop(`${name}.wgsl`, edited(edits).source);
        assert.ok(!error.includes(name), error);
        const text = await this.compared();
        const told = /First in pass (\d+), intersect, for the ray of pixel (\d+),(\d+): (\S+) is (\S+), expected (\S+)/.exec(text);
        assert.ok(told, `${name}: ${text}`);
        assert.match(text, /^\d+ rays differ from what the built-in kernels do/);
        const [, pass, x, y, ...found] = told;
        // Every ray's first pass of intersect comes after its setup.
        assert.ok(Number(pass) >= 2 && Number(x) < 16 && Number(y) < 16, `${name}: ${text}`);
        assert.ok(component.test?.(found[0]) ?? component === found[0], `${name}: ${text}`);
        assert.notEqual(found[1], found[2], name);
        if (value !== undefined) {
            assert.deepEqual(found.slice(1), [value, expected], `${name}: ${text}`);
        }
        return told[0];
    }
}

/// In the page: whether it was busy, and what it copies.
function observe() {
    const observed = (window.observed = { wasBusy: false, copied: [], saved: [] });
    let isBusy = window.raystep.isBusy;
    Object.defineProperty(window.raystep, "isBusy", {
        get: () => isBusy,
        set: (value) => {
            observed.wasBusy ||= value;
            isBusy = value;
        },
    });
    // There is one clipboard for everybody.
    navigator.clipboard.writeText = async (text) => observed.copied.push(text);
    // What is saved, without a folder of downloads.
    const create = URL.createObjectURL;
    URL.createObjectURL = (blob) => {
        observed.saved.push(blob);
        return create(blob);
    };
}

/// What was told of each mistake, on the device before.
const said = {};

for (const [way, device] of [
    ["webgpu", "gpu"],
    ["webgl", "cpu"],
]) {
    describe(`${way}, kernels run on the ${device}`, () => {
        let [browser, bench] = [];
        before(async () => {
            browser = await Browser.open(way);
            bench = await Bench.open(browser, device);
        });
        after(() => browser.close());

        test("what cannot be composed or compiled is named with its line and column", async () => {
            // What composes and compiles is the same on both.
            for (const mistake of device === "gpu" ? REFUSED : REFUSED.slice(0, 4)) {
                await bench.refused(mistake, true);
            }
            await bench.mended("after all of them");
        });

        test("what a run must not do is named with its line, or with what it leaves", async () => {
            const error = await bench.refused(ENDLESS);
            assert.match(error, device === "gpu" ? /that a pass may have on this device/ : /for the ray of pixel \d+,\d+$/);
            await bench.mended("endless");
            for (const [mistake, message, component] of [
                [OUTSIDE, " is outside of grid_cells, which has 145 elements, for the ray of pixel ", /^state\.\w+$/],
                [RACE, " of state belongs to another element, whose thread runs at the same time, for the ray of pixel ", "state.item"],
            ]) {
                if (device === "gpu") {
                    console.log(`${mistake[0]}: ${await bench.differs([...mistake, component])}`);
                } else {
                    await bench.refused([...mistake, message]);
                }
                await bench.mended(mistake[0]);
            }
        });

        test("other values are named with the first pass, pixel and stream in which they differ", async () => {
            for (const mistake of WRONG) {
                const told = await bench.differs(mistake);
                console.log(`${mistake[0]}: ${told}`);
                // This software driver rounds as the CPU does.
                assert.equal(told, (said[mistake[0]] ??= told));
                if (mistake[0] === "off-by-one") {
                    await bench.tab.screenshot(`${way}-own-kernel-differs`);
                }
                await bench.mended(mistake[0]);
            }
            assert.match(await bench.compared(), /rays? tie|No ray differs|f64 decides otherwise/);
        });

        test("a tie that goes to the other triangle is named, but on a GPU, where either is right", async () => {
            const doubled = JSON.parse(readFileSync(path.join(scenes, "cornell-box.gltf"), "utf8"));
            const corners = ({ attributes, indices }) => doubled.accessors[indices ?? attributes.POSITION].count;
            const count = doubled.meshes[0].primitives.reduce((sum, primitive) => sum + corners(primitive) / 3, 0);
            doubled.meshes[0].primitives.push(...doubled.meshes[0].primitives);
            const { link } = await bench.done(() => bench.tab.drop([["doubled.gltf", JSON.stringify(doubled)]]));
            assert.equal(keyOf(link, "scene"), "doubled.gltf");
            bench.picture = await bench.exported();
            const mistake = ["tie", [[NEARER, "(candidate.t <= nearest_t)"]], "hit.triangle"];
            if (device === "gpu") {
                await bench.drop("tie.wgsl", edited(mistake[1]).source);
                // It may round so that there is no tie: either triangle is right.
                assert.match(await bench.compared(), /^\d+ rays tie: f32 cannot decide their branch/);
            } else {
                const told = await bench.differs(mistake);
                const [value, expected] = /is (\d+), expected (\d+)$/.exec(told).slice(1).map(Number);
                assert.equal(value, expected + count, told);
            }
            await bench.mended("tie");
        });

        test("nothing was lost meanwhile", () => assert.deepEqual(bench.tab.troubles, []));
    });
}
