// `raystep debug-adapter` with the client that the authors of the Debug Adapter Protocol test adapters with. RAYSTEP is the program.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, realpathSync, rmSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import path from "node:path";
import { after, afterEach, beforeEach, test } from "node:test";

const { DebugClient } = createRequire(import.meta.url)("@vscode/debugadapter-testsupport");

const raystep = process.env.RAYSTEP;
const folder = realpathSync(mkdtempSync(path.join(tmpdir(), "raystep-")));
const program = path.join(folder, "life");
const file = path.join(program, "generation.wgsl");
execFileSync(raystep, ["new", program, "--like", "life"]);
const lines = readFileSync(file, "utf8").split("\n");
/// The line, from 1, that begins with a text.
const line = (begins) => lines.findIndex((text) => text.trim().startsWith(begins)) + 1;

let client;
beforeEach(async () => {
    client = new DebugClient(raystep, "debug-adapter", "raystep");
    // In software, on a machine that does other things too.
    client.defaultTimeout = 60000;
    await client.start();
});
afterEach(() => client.stop());
after(() => rmSync(folder, { recursive: true }));

const launch = { program, kernel: "generation", element: [3, 2] };

test("what it can do is told", async () => {
    const { body } = await client.initializeRequest();
    for (const name of ["supportsStepBack", "supportsConditionalBreakpoints", "supportsEvaluateForHovers"]) {
        assert.equal(body[name], true, name);
    }
});

test("it stops at the first statement", async () => {
    await Promise.all([
        client.waitForEvent("initialized").then(() => client.configurationDoneRequest()),
        client.launch({ ...launch, stopOnEntry: true }),
        client.assertStoppedLocation("entry", { path: file, line: line("let size") }),
    ]);
});

test("a breakpoint is hit, variables are shown, and steps go on and back", async () => {
    await client.hitBreakpoint(launch, { path: file, line: line("let there") });
    const { body: stack } = await client.stackTraceRequest({ threadId: 1 });
    const { body: scopes } = await client.scopesRequest({ frameId: stack.stackFrames[0].id });
    const { variablesReference } = scopes.scopes.find((scope) => scope.name === "Locals");
    const { body: locals } = await client.variablesRequest({ variablesReference });
    assert.deepEqual(locals.variables.map((variable) => variable.name), ["id", "size", "neighbours", "i"]);
    await Promise.all([
        client.nextRequest({ threadId: 1 }),
        client.assertStoppedLocation("step", { path: file, line: line("neighbours +=") }),
    ]);
    const { body } = await client.evaluateRequest({ expression: "there", context: "hover" });
    assert.equal(body.result, "(2, 1)");
    await Promise.all([
        client.stepBackRequest({ threadId: 1 }),
        client.assertStoppedLocation("step", { path: file, line: line("let there") }),
    ]);
});

test("a condition chooses the turn of a loop", async () => {
    await client.hitBreakpoint(launch, { path: file, line: line("neighbours +=") });
    const breakpoints = [{ line: line("neighbours +="), condition: "i == 5u" }];
    await client.setBreakpointsRequest({ source: { path: file }, breakpoints });
    await Promise.all([
        client.continueRequest({ threadId: 1 }),
        client.assertStoppedLocation("breakpoint", { path: file, line: line("neighbours +=") }),
    ]);
    const { body } = await client.evaluateRequest({ expression: "i" });
    assert.equal(body.result, "5");
    await Promise.all([client.continueRequest({ threadId: 1 }), client.waitForEvent("stopped")]);
    await Promise.all([client.continueRequest({ threadId: 1 }), client.waitForEvent("terminated")]);
});
