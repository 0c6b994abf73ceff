// Runs the inspector: the module's imports, its frames, and the events of the page.

import init, { Window, work } from "./raystep_web.js";

let inspector = null;
/// Events that came before the inspector was ready.
const waiting = [];

const post = (kind, values = {}, transfer = []) => self.postMessage({ kind, ...values }, transfer);

// Frames: at most one of the display, and one later, are asked for at a time.
let isFrameAsked = false;
let timer = 0;
let timerAt = Infinity;

function frame() {
    isFrameAsked = false;
    if (inspector === null) {
        return;
    }
    guarded(() => {
        const why = inspector.frame();
        post("frame", { busy: inspector.is_busy(), place: inspector.place() });
        if (why !== undefined) {
            lost(why);
        }
    });
}

/// Nothing can be drawn any more; the page offers to go on at the same place.
function lost(why) {
    const link = inspector?.link() ?? "";
    inspector = null;
    post("lost", { why, link });
}

function wake(afterMs) {
    if (afterMs <= 0) {
        if (!isFrameAsked) {
            isFrameAsked = true;
            self.requestAnimationFrame(frame);
        }
        return;
    }
    const at = self.performance.now() + afterMs;
    // Longer than a day is never.
    if (at < timerAt && afterMs < 86_400_000) {
        clearTimeout(timer);
        timerAt = at;
        timer = setTimeout(() => {
            timerAt = Infinity;
            wake(0);
        }, afterMs);
    }
}

// Work goes on through messages to ourselves, between which the page's events are served; they are not slowed down while
// the page is hidden, as timers are.
const channel = new MessageChannel();
channel.port1.onmessage = () => guarded(work);

/// What a panic or an exception leaves behind cannot go on.
function guarded(work) {
    try {
        work();
    } catch (error) {
        failed(error);
    }
}

function failed(error) {
    inspector = null;
    console.error(error);
    post("failed", { why: String(error?.message ?? error) });
}

async function fetchBytes(url, mostBytes, progress) {
    const abort = new AbortController();
    const stop = () => abort.abort(new Error("cancelled"));
    let done = 0;
    let total = 0;
    // Also while nothing arrives, a cancelled request ends.
    const check = setInterval(() => progress(done, total) || stop(), 200);
    try {
        const response = await fetch(url, {
            credentials: "omit",
            referrerPolicy: "no-referrer",
            signal: abort.signal,
        });
        if (!response.ok) {
            throw new Error(`the server answers ${response.status} ${response.statusText}`);
        }
        const tooLarge = () => new Error(`it is larger than the limit of ${mostBytes} bytes`);
        // The length is that of what is sent, which may be compressed.
        total = response.headers.get("content-encoding") ? 0 : Number(response.headers.get("content-length") ?? 0);
        if (total > mostBytes) {
            throw tooLarge();
        }
        const parts = [];
        for (const reader = response.body.getReader(); ;) {
            const { done: isDone, value } = await reader.read();
            if (isDone) {
                break;
            }
            parts.push(value);
            done += value.length;
            if (done > mostBytes) {
                throw tooLarge();
            }
        }
        return new Uint8Array(await new Blob(parts).arrayBuffer());
    } catch (error) {
        stop();
        if (error instanceof TypeError) {
            throw new Error(`cannot be fetched (${error.message}); the server may not allow other pages to read it`);
        }
        throw error;
    } finally {
        clearInterval(check);
    }
}

self.raystep = {
    now: () => self.performance.now(),
    wake,
    later: () => channel.port2.postMessage(null),
    cursor: (name) => post("cursor", { name }),
    copy: (text) => post("copy", { text }),
    visit: (url) => post("visit", { url }),
    editing: (rect) => post("editing", { rect: Array.from(rect) }),
    title: (text) => post("title", { text }),
    address: (link) => post("address", { link }),
    keep: (saved) => post("keep", { saved }),
    download: (name, bytes) => post("download", { name, bytes }, [bytes.buffer]),
    choose: (endings) => post("choose", { endings }),
    ask_for: (name, endings) => post("askFor", { name, endings }),
    tell: (text) => post("tell", { text }),
    fetch: fetchBytes,
};

const state = () => ({
    // A frame that is asked for may find more to do.
    busy: inspector.is_busy() || isFrameAsked,
    link: inspector.link(),
    place: inspector.place(),
    error: inspector.last_error(),
    device: inspector.device(),
    bytes: inspector.memory_bytes(),
    size: Array.from(inspector.size()),
});

const handlers = {
    resize: (e) => inspector.resize(e.width, e.height, e.scale),
    pointerMoved: (e) => inspector.pointer_moved(e.x, e.y, e.modifiers),
    pointerButton: (e) => inspector.pointer_button(e.x, e.y, e.button, e.pressed, e.modifiers),
    pointerGone: () => inspector.pointer_gone(),
    touch: (e) => inspector.touch(e.id, e.phase, e.x, e.y, e.force),
    wheel: (e) => inspector.wheel(e.x, e.y, e.unit, e.modifiers),
    key: (e) => inspector.key(e.name, e.code, e.pressed, e.repeat, e.modifiers),
    text: (e) => inspector.text(e.text),
    compose: (e) => inspector.compose(e.text, e.isDone),
    copy: (e) => inspector.copy(e.cuts),
    paste: (e) => inspector.paste(e.text),
    focus: (e) => inspector.focus(e.hasFocus),
    files: (e) => inspector.files(e.paths, e.files),
    cancelled: () => inspector.cancelled(),
    go: (e) => inspector.go(e.link),
    keep: () => inspector.keep(),
    ask: (e) => post("answer", { id: e.id, state: state() }),
};

/// The module, which is stored compressed; a server may have told the browser, which then has expanded it.
async function module() {
    const response = await fetch(new URL("raystep_web_bg.wasm.gz", import.meta.url));
    if (!response.ok) {
        throw new Error(`raystep_web_bg.wasm.gz: the server answers ${response.status} ${response.statusText}`);
    }
    const [peeked, whole] = response.body.tee();
    const reader = peeked.getReader();
    const { value: first } = await reader.read();
    reader.cancel();
    const isCompressed = first?.[0] === 0x1f && first?.[1] === 0x8b;
    post("loaded");
    const bytes = isCompressed ? whole.pipeThrough(new DecompressionStream("gzip")) : whole;
    return new Response(bytes, { headers: { "content-type": "application/wasm" } });
}

async function start({ canvas, width, height, scale, isDark, saved, link, isEmbedded, lesson, step }) {
    // WebGPU tells by its device.
    canvas.addEventListener("webglcontextlost", () => lost("the browser took back the context of WebGL"));
    await init({ module_or_path: module() });
    inspector = await Window.open(canvas, width, height, scale, isDark, saved ?? undefined);
    if (isEmbedded) {
        inspector.embed();
    }
    if (lesson) {
        inspector.lesson(lesson, step);
    } else {
        inspector.go(link);
    }
    post("ready", { computes: inspector.computes() });
    for (const event of waiting.splice(0)) {
        guarded(() => handlers[event.kind](event));
    }
    wake(0);
}

self.onmessage = ({ data }) => {
    if (data.kind === "start") {
        start(data).catch(failed);
    } else if (inspector === null) {
        waiting.push(data);
    } else {
        guarded(() => handlers[data.kind](data));
    }
};
