// The page around the inspector: passes events on to the worker that runs it, and does what only a page can.

const canvas = document.getElementById("canvas");
const text = document.getElementById("text");
const chooser = document.getElementById("chooser");

// `?embed`: a part of another page, without menus. `?lesson=NAME&step=N`: begins a lesson.
const query = new URLSearchParams(location.search);
const isEmbedded = query.has("embed");

const STORED = "raystep";
const FIRST_LINK = "raystep:1?scene=scenes/cornell-box.gltf";
/// Without an answer for so long, the page says that the worker is at work.
const PATIENCE_MS = 700;

const worker = new Worker("worker.js", { type: "module" });
const post = (kind, values = {}, transfer = []) => worker.postMessage({ kind, ...values }, transfer);

// For tests, and for pages that embed this one: `await raystep.state()` tells whether anything is left to do, the link to what is
// shown, the number of passes that have run, the last error, the device, and the bytes of memory.
const asked = new Map();
let lastAsked = 0;
window.raystep = {
    isReady: false,
    isBusy: true,
    frames: 0,
    place: 0,
    go: (link) => post("go", { link }),
    state: () =>
        new Promise((resolve) => {
            const id = (lastAsked += 1);
            asked.set(id, resolve);
            post("ask", { id });
        }),
};

function stored() {
    try {
        return localStorage.getItem(STORED);
    } catch {
        // A page may not be allowed to store anything.
        return null;
    }
}

function store(saved) {
    try {
        localStorage.setItem(STORED, saved);
    } catch {
        // The next visit begins with defaults.
    }
}

// The panel over the canvas: a question, a wait, or the end.

const panel = document.getElementById("panel");
const message = document.getElementById("message");
const buttons = document.getElementById("buttons");
const progress = document.getElementById("progress");

function show(line, actions = [], isWaiting = false) {
    message.textContent = line;
    progress.hidden = !isWaiting;
    buttons.replaceChildren(
        ...actions.map(([name, act]) => {
            const button = document.createElement("button");
            button.textContent = name;
            button.addEventListener("click", act);
            return button;
        }),
    );
    panel.hidden = false;
}

function hide() {
    panel.hidden = true;
    canvas.focus();
}

function reloadAt(link) {
    if (link) {
        history.replaceState(null, "", `#${link}`);
    }
    location.reload();
}

/// Nothing can be shown: what is missing, and how it would look.
function showPictures(why) {
    show(`raystep cannot run in this browser: ${why}.`);
    const pictures = document.getElementById("pictures");
    for (const [file, caption] of [
        ["full.png", "The inspector: an image, its passes, and the streams between them"],
        ["walk.png", "One ray's walk through the voxels"],
        ["compare.png", "Two runs, compared pass by pass"],
    ]) {
        const figure = document.createElement("figure");
        const image = document.createElement("img");
        image.src = `pictures/${file}`;
        image.alt = caption;
        const words = document.createElement("figcaption");
        words.textContent = caption;
        figure.append(image, words);
        pictures.append(figure);
    }
    pictures.hidden = false;
}

// Whether the worker answers.

let pingedAt = 0;
let isWaitShown = false;
let isAsking = false;

function ping() {
    if (pingedAt === 0) {
        pingedAt = performance.now();
    }
}

function answered() {
    pingedAt = 0;
    if (isWaitShown) {
        isWaitShown = false;
        hide();
    }
}

setInterval(() => {
    // A hidden page draws no frames.
    if (document.hidden || !window.raystep.isReady) {
        pingedAt = 0;
    } else if (pingedAt !== 0 && performance.now() - pingedAt > PATIENCE_MS && panel.hidden) {
        isWaitShown = true;
        show("Working…", [["Stop, and start again", () => reloadAt(`${FIRST_LINK}`)]], true);
    }
}, 200);

// What the worker says.

const download = ({ name, bytes }) => {
    const url = URL.createObjectURL(new Blob([bytes]));
    const anchor = document.createElement("a");
    anchor.href = url;
    anchor.download = name;
    anchor.click();
    setTimeout(() => URL.revokeObjectURL(url), 60_000);
};

async function copyText(words) {
    try {
        await navigator.clipboard.writeText(words);
    } catch {
        // Without a secure connection there is no clipboard, only the selection.
        text.value = words;
        text.select();
        document.execCommand("copy");
        text.value = "";
    }
}

const handlers = {
    loaded: () => {
        window.raystep.loadedAt = performance.now();
        show("Opening a device…", [], true);
    },
    ready: ({ computes }) => {
        window.raystep.isReady = true;
        window.raystep.drawnBy = computes ? "WebGPU" : "WebGL 2";
        hide();
    },
    frame: ({ busy, place }) => {
        window.raystep.isBusy = busy;
        window.raystep.place = place;
        window.raystep.frames += 1;
        answered();
    },
    answer: ({ id, state }) => {
        asked.get(id)?.(state);
        asked.delete(id);
    },
    failed: ({ why }) => {
        const isStarted = window.raystep.isReady;
        window.raystep.isReady = false;
        window.raystep.failure = why;
        if (isStarted) {
            show(`raystep stopped: ${why}`, [["Start again", () => reloadAt("")]]);
        } else {
            showPictures(/WebGL 2/.test(why) ? "it has neither WebGPU nor WebGL 2" : why);
        }
    },
    lost: ({ why, link }) => {
        window.raystep.isReady = false;
        window.raystep.failure = why;
        show(`raystep stopped: ${why}.`, [["Resume at the same place", () => reloadAt(link)]]);
    },
    cursor: ({ name }) => {
        canvas.style.cursor = name;
    },
    copy: ({ text: words }) => copyText(words),
    visit: ({ url }) => window.open(url, "_blank", "noopener,noreferrer"),
    editing: ({ rect }) => {
        if (rect.length === 4) {
            text.style.left = `${rect[0]}px`;
            text.style.top = `${rect[1]}px`;
            if (document.activeElement === canvas) {
                text.focus({ preventScroll: true });
            }
        } else if (document.activeElement === text) {
            text.value = "";
            canvas.focus();
        }
    },
    title: ({ text: words }) => {
        document.title = words;
    },
    address: ({ link }) => history.replaceState(null, "", `#${link}`),
    keep: ({ saved }) => isEmbedded || store(saved),
    download,
    choose: ({ endings }) => choose(endings),
    askFor: ({ name }) => {
        if (name === "") {
            isAsking = false;
            hide();
            return;
        }
        isAsking = true;
        show(`The link is of ${name}, a file that is not on this server. Choose it, or drop it here, with the files that it needs.`, [
            ["Choose…", () => choose(".gltf,.glb,.bin,.png,.jpg,.jpeg")],
            ["Cancel", () => post("cancelled")],
        ]);
    },
    tell: ({ text: words }) => {
        document.getElementById("told").textContent = words;
    },
};

worker.onmessage = ({ data }) => handlers[data.kind](data);
worker.onerror = (event) => {
    event.preventDefault();
    handlers.failed({ why: event.message ?? "the worker could not be loaded" });
};

// Files.

function choose(endings) {
    chooser.accept = endings;
    chooser.value = "";
    chooser.click();
}

function give(files) {
    post("files", { paths: files.map(([path]) => path), files: files.map(([, file]) => file) });
}

chooser.addEventListener("change", () => give(Array.from(chooser.files, (file) => [file.name, file])));
chooser.addEventListener("cancel", () => isAsking || post("cancelled"));

/// The files of an entry of a drop, folders with all that is in them.
async function filesOf(entry, folder = "") {
    const path = folder + entry.name;
    if (entry.isFile) {
        return [[path, await new Promise((resolve, reject) => entry.file(resolve, reject))]];
    }
    const reader = entry.createReader();
    const found = [];
    // It gives a hundred at a time.
    for (; ;) {
        const some = await new Promise((resolve, reject) => reader.readEntries(resolve, reject));
        if (some.length === 0) {
            return found;
        }
        for (const one of some) {
            found.push(...(await filesOf(one, `${path}/`)));
        }
    }
}

document.addEventListener("dragover", (event) => event.preventDefault());
document.addEventListener("drop", async (event) => {
    event.preventDefault();
    const link = event.dataTransfer.getData("text/plain");
    const entries = Array.from(event.dataTransfer.items, (item) => item.webkitGetAsEntry?.()).filter(Boolean);
    const plain = Array.from(event.dataTransfer.files, (file) => [file.name, file]);
    if (entries.length > 0) {
        give((await Promise.all(entries.map((entry) => filesOf(entry)))).flat());
    } else if (plain.length > 0) {
        give(plain);
    } else if (link.startsWith("raystep:")) {
        post("go", { link });
    }
});

// The canvas.

const isMac = /Mac|iPhone|iPad/.test(navigator.platform);
const modifiers = (e) =>
    (e.altKey ? 1 : 0) | (e.ctrlKey ? 2 : 0) | (e.shiftKey ? 4 : 0) | (e.metaKey ? 8 : 0) | (isMac ? 16 : 0);

function size() {
    const { width, height } = canvas.getBoundingClientRect();
    return { width: Math.max(width, 1), height: Math.max(height, 1), scale: window.devicePixelRatio || 1 };
}

new ResizeObserver(() => post("resize", size())).observe(canvas);

/// The ratio of pixels changes with the page's zoom, and between displays.
function watchScale() {
    matchMedia(`(resolution: ${window.devicePixelRatio}dppx)`).addEventListener(
        "change",
        () => {
            post("resize", size());
            watchScale();
        },
        { once: true },
    );
}
watchScale();

const touches = new Map();

function pointer(event) {
    const place = { x: event.offsetX, y: event.offsetY, modifiers: modifiers(event) };
    const phase = { pointerdown: 0, pointermove: 1, pointerup: 2, pointercancel: 3 }[event.type];
    if (event.pointerType === "touch") {
        post("touch", { id: event.pointerId, phase, x: place.x, y: place.y, force: event.pressure });
        // The first finger is also a mouse.
        if (phase === 0 && touches.size === 0) {
            touches.set(event.pointerId, true);
        }
        if (!touches.has(event.pointerId)) {
            return;
        }
    }
    switch (event.type) {
        case "pointerdown":
            canvas.setPointerCapture(event.pointerId);
            if (document.activeElement !== text) {
                canvas.focus();
            }
            ping();
            post("pointerButton", { ...place, button: event.button, pressed: true });
            break;
        case "pointerup":
            ping();
            post("pointerButton", { ...place, button: event.button, pressed: false });
            break;
        case "pointermove":
            post("pointerMoved", place);
            break;
    }
    if (event.pointerType === "touch" && phase >= 2) {
        touches.delete(event.pointerId);
        post("pointerGone");
    }
    event.preventDefault();
}

for (const kind of ["pointerdown", "pointermove", "pointerup", "pointercancel"]) {
    canvas.addEventListener(kind, pointer);
}
canvas.addEventListener("pointerleave", () => post("pointerGone"));
canvas.addEventListener("contextmenu", (event) => event.preventDefault());
canvas.addEventListener(
    "wheel",
    (event) => {
        event.preventDefault();
        post("wheel", { x: event.deltaX, y: event.deltaY, unit: event.deltaMode, modifiers: modifiers(event) });
    },
    { passive: false },
);

// Keys. The browser keeps those that leave or reload the page, and those of the clipboard, which come as events of their
// own.

const KEPT = new Set(["r", "t", "n", "w", "tab"]);
const OF_CLIPBOARD = new Set(["c", "x", "v"]);
const OF_DEVELOPERS = new Set(["i", "j"]);

function isOfBrowser(event) {
    const isCommand = isMac ? event.metaKey : event.ctrlKey;
    const name = event.key.toLowerCase();
    return isCommand && (KEPT.has(name) || (event.shiftKey ? OF_DEVELOPERS : OF_CLIPBOARD).has(name));
}

function key(event) {
    if (isOfBrowser(event)) {
        return;
    }
    if (event.isComposing || event.key === "Process" || event.key === "Unidentified") {
        return;
    }
    ping();
    post("key", {
        name: event.key,
        code: event.code,
        pressed: event.type === "keydown",
        repeat: event.repeat,
        modifiers: modifiers(event),
    });
    event.preventDefault();
}

for (const element of [canvas, text]) {
    element.addEventListener("keydown", key);
    element.addEventListener("keyup", key);
}
text.addEventListener("input", (event) => {
    // Keys of a screen keyboard come as texts.
    if (!event.isComposing && text.value !== "") {
        post("text", { text: text.value });
        text.value = "";
    }
});
text.addEventListener("compositionupdate", (event) => post("compose", { text: event.data, isDone: false }));
text.addEventListener("compositionend", (event) => {
    post("compose", { text: event.data, isDone: true });
    text.value = "";
});

document.addEventListener("copy", (event) => {
    event.preventDefault();
    post("copy", { cuts: false });
});
document.addEventListener("cut", (event) => {
    event.preventDefault();
    post("copy", { cuts: true });
});
document.addEventListener("paste", (event) => {
    event.preventDefault();
    const pasted = event.clipboardData.getData("text/plain");
    if (pasted) {
        post("paste", { text: pasted });
    }
});

window.addEventListener("focus", () => post("focus", { hasFocus: true }));
window.addEventListener("blur", () => post("focus", { hasFocus: false }));
document.addEventListener("visibilitychange", () => document.hidden && post("keep"));

// The address.

const linkOf = (hash) => {
    const link = hash.replace(/^#/, "");
    return link.startsWith("raystep:") ? link : "";
};
window.addEventListener("hashchange", () => {
    const link = linkOf(location.hash);
    if (link) {
        post("go", { link });
    }
});

show("Loading raystep…", [], true);
if (typeof canvas.transferControlToOffscreen !== "function") {
    showPictures("it cannot draw from a Web Worker (OffscreenCanvas)");
} else {
    const offscreen = canvas.transferControlToOffscreen();
    const isDark = matchMedia("(prefers-color-scheme: dark)").matches;
    post(
        "start",
        {
            canvas: offscreen,
            ...size(),
            isDark,
            // A part of another page begins as its author wanted.
            saved: isEmbedded ? null : stored(),
            link: linkOf(location.hash) || FIRST_LINK,
            isEmbedded,
            lesson: query.get("lesson"),
            step: Math.max(1, Math.trunc(Number(query.get("step"))) || 1),
        },
        [offscreen],
    );
}
canvas.focus();
