// The page around the inspector: passes events on to the worker that runs it, and does what only a page can.

import * as canvas from "./canvas.js";
import * as files from "./files.js";
import * as panel from "./panel.js";

const element = document.getElementById("canvas");

// `?embed`: a part of another page, without menus. `?lesson=NAME&step=N`: begins a lesson.
const query = new URLSearchParams(location.search);
const isEmbedded = query.has("embed");

const STORED = "raystep";
const FIRST_LINK = "raystep:1?scene=scenes/cornell-box.gltf";
/// Without an answer for so long, the page says that the worker is at work.
const PATIENCE_MS = 700;

const worker = new Worker("worker.js", { type: "module" });
const post = (kind, values = {}, transfer = []) => worker.postMessage({ kind, ...values }, transfer);

// For tests, and for pages that embed this one: `await raystep.state()` tells whether anything is left to do, the link to
// what is shown, the number of passes that have run, the last error, the device, the bytes of memory, and the pixels.
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

function reloadAt(link) {
    if (link) {
        history.replaceState(null, "", `#${link}`);
    }
    location.reload();
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
        panel.hide();
    }
}

setInterval(() => {
    // A hidden page draws no frames.
    if (document.hidden || !window.raystep.isReady) {
        pingedAt = 0;
    } else if (pingedAt !== 0 && performance.now() - pingedAt > PATIENCE_MS && panel.isHidden()) {
        isWaitShown = true;
        panel.show("Working…", [["Stop, and start again", () => reloadAt(FIRST_LINK)]], true);
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

const handlers = {
    loaded: () => {
        window.raystep.loadedAt = performance.now();
        panel.show("Opening a device…", [], true);
    },
    ready: ({ computes }) => {
        window.raystep.isReady = true;
        window.raystep.drawnBy = computes ? "WebGPU" : "WebGL 2";
        panel.hide();
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
            panel.show(`raystep stopped: ${why}`, [["Start again", () => reloadAt("")]]);
        } else {
            panel.showPictures(/WebGL 2/.test(why) ? "it has neither WebGPU nor WebGL 2" : why);
        }
    },
    lost: ({ why, link }) => {
        window.raystep.isReady = false;
        window.raystep.failure = why;
        panel.show(`raystep stopped: ${why}.`, [["Resume at the same place", () => reloadAt(link)]]);
    },
    cursor: ({ name }) => {
        element.style.cursor = name;
    },
    copy: ({ text: words }) => canvas.copyText(words),
    visit: ({ url }) => /^https?:/.test(url) && window.open(url, "_blank", "noopener,noreferrer"),
    editing: ({ rect }) => canvas.edit(rect),
    title: ({ text: words }) => {
        document.title = words;
    },
    address: ({ link }) => history.replaceState(null, "", `#${link}`),
    keep: ({ saved }) => isEmbedded || store(saved),
    download,
    choose: ({ endings }) => files.choose(endings),
    askFor: ({ name, endings }) => {
        if (name === "") {
            isAsking = false;
            panel.hide();
            return;
        }
        isAsking = true;
        panel.show(`The link is of ${name}, a file that is not on this server. Choose it, or drop it here, with the files that it needs.`, [
            ["Choose…", () => files.choose(endings)],
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

files.listen({
    give: (given) => post("files", { paths: given.map(([path]) => path), files: given.map(([, file]) => file) }),
    // A question stays until it is answered.
    cancel: () => isAsking || post("cancelled"),
    go: (link) => post("go", { link }),
});

canvas.listen(post, ping);

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

panel.show("Loading raystep…", [], true);
if (typeof element.transferControlToOffscreen !== "function") {
    panel.showPictures("it cannot draw from a Web Worker (OffscreenCanvas)");
} else {
    const offscreen = element.transferControlToOffscreen();
    const isDark = matchMedia("(prefers-color-scheme: dark)").matches;
    post(
        "start",
        {
            canvas: offscreen,
            ...canvas.size(),
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
element.focus();
