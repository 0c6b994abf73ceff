// Every variant of every kernel, those that are fragment programs, and the shaders that draw, compiled by Dawn, Chromium's WebGPU, on a device with no more
// than core limits. The folder RAYSTEP_SHADERS has the variants.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync, readdirSync } from "node:fs";
import { createRequire } from "node:module";
import path from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";

const own = fileURLToPath(import.meta.url);
/// SwiftShader, a software Vulkan, aborts after some hundred pipelines of a process.
const A_PROCESS = 40;
const CORE = { maxStorageTexturesPerShaderStage: 4, maxStorageBuffersPerShaderStage: 8, maxComputeInvocationsPerWorkgroup: 256, maxStorageBufferBindingSize: 134217728 };

/// The shaders that draw, as the inspector puts them together.
function drawing() {
    const folder = path.join(path.dirname(own), "../../inspector/src/draw");
    const source = (name) => readFileSync(path.join(folder, name), "utf8");
    const view = source("scene3d/view.wgsl");
    return [
        ["stream.wgsl", source("stream.wgsl")],
        ["triangles.wgsl", `${view}\n${source("scene3d/triangles.wgsl")}`],
        ["overlay.wgsl", `${view}\n${source("scene3d/overlay.wgsl")}`],
    ];
}

/// What the fragment programs of kernels are drawn with.
const QUAD = `@vertex fn quad(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(2.0 * vec2f(f32(index & 1u), f32(index >> 1u)) - 1.0, 0.0, 1.0);
}`;

/// The pipeline of a kernel as a fragment program: a target of rgba32uint for each stream that it writes, or depths.
function drawn(device, module, code) {
    const count = new Set(code.match(/@location\(\d+\)/g) ?? []).size;
    const targets = Array.from({ length: count }, () => ({ format: "rgba32uint" }));
    return device.createRenderPipelineAsync({
        layout: "auto",
        vertex: { module: device.createShaderModule({ code: QUAD }) },
        primitive: { topology: "triangle-strip" },
        fragment: { module, targets },
        ...(count === 0 && { depthStencil: { format: "depth32float", depthWriteEnabled: true, depthCompare: "always" } }),
    });
}

/// Compiles files, and modules without a pipeline where there is no compute stage; prints the errors.
async function compile(sources) {
    const { create, globals } = createRequire(own)("webgpu");
    Object.assign(globalThis, globals);
    // Kept: without a reference, it is freed while it is in use.
    globalThis.gpu = create([]);
    const adapter = await globalThis.gpu.requestAdapter();
    const device = await adapter.requestDevice({ requiredLimits: CORE });
    for (const [name, code] of sources) {
        device.pushErrorScope("validation");
        const module = device.createShaderModule({ code });
        const { messages } = await module.getCompilationInfo();
        for (const { type, message, lineNum } of messages) {
            if (type === "error") {
                console.log(`${name}:${lineNum}: ${message}`);
            }
        }
        if (code.includes("@compute")) {
            await device.createComputePipelineAsync({ layout: "auto", compute: { module } }).catch((error) => console.log(`${name}: ${error.message}`));
        }
        if (name.startsWith("draw-") && code.includes("@fragment")) {
            await drawn(device, module, code).catch((error) => console.log(`${name}: ${error.message}`));
        }
        const error = await device.popErrorScope();
        if (error && messages.length === 0) {
            console.log(`${name}: ${error.message}`);
        }
    }
    process.exit(0);
}

if (process.argv[2] === "--compile") {
    await compile(process.argv[3] === "drawing" ? drawing() : process.argv.slice(3).map((file) => [path.basename(file), readFileSync(file, "utf8")]));
}

const run = (files) => execFileSync(process.execPath, [own, "--compile", ...files], { encoding: "utf8" });

test("every variant of every kernel compiles in Dawn with core limits", () => {
    const folder = process.env.RAYSTEP_SHADERS;
    assert.ok(folder, "RAYSTEP_SHADERS names the folder of variants");
    const files = readdirSync(folder).map((name) => path.join(folder, name));
    assert.ok(files.length > 100, `${files.length} variants`);
    let errors = "";
    for (let first = 0; first < files.length; first += A_PROCESS) {
        errors += run(files.slice(first, first + A_PROCESS));
    }
    assert.equal(errors, "");
    const programs = files.filter((file) => path.basename(file).startsWith("draw-")).length;
    assert.ok(programs > 100, `${programs} fragment programs`);
    console.log(`${files.length - programs} compute shaders, ${programs} fragment programs`);
});

test("the shaders that draw compile in Dawn", () => {
    assert.equal(run(["drawing"]), "");
});
