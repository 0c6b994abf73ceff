// What the user does with the canvas: pointer, keys, texts, clipboard, and its size.

const canvas = document.getElementById("canvas");
const text = document.getElementById("text");

const isMac = /Mac|iPhone|iPad/.test(navigator.platform);
const modifiers = (e) =>
    (e.altKey ? 1 : 0) | (e.ctrlKey ? 2 : 0) | (e.shiftKey ? 4 : 0) | (e.metaKey ? 8 : 0) | (isMac ? 16 : 0);

/// The canvas in CSS pixels, and device pixels per CSS pixel.
export function size() {
    const { width, height } = canvas.getBoundingClientRect();
    return { width: Math.max(width, 1), height: Math.max(height, 1), scale: window.devicePixelRatio || 1 };
}

/// Calls `post` with the name and the values of every event, and `act` before those that the user waits for.
export function listen(post, act) {
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

    /// The finger that is also a mouse.
    let finger = null;

    function pointer(event) {
        const place = { x: event.offsetX, y: event.offsetY, modifiers: modifiers(event) };
        const phase = { pointerdown: 0, pointermove: 1, pointerup: 2, pointercancel: 3 }[event.type];
        if (event.pointerType === "touch") {
            post("touch", { id: event.pointerId, phase, x: place.x, y: place.y, force: event.pressure });
            if (phase === 0) {
                finger ??= event.pointerId;
            }
            if (finger !== event.pointerId) {
                return;
            }
        }
        switch (event.type) {
            case "pointerdown":
                canvas.setPointerCapture(event.pointerId);
                if (document.activeElement !== text) {
                    canvas.focus();
                }
                act();
                post("pointerButton", { ...place, button: event.button, pressed: true });
                break;
            case "pointerup":
                act();
                post("pointerButton", { ...place, button: event.button, pressed: false });
                break;
            case "pointermove":
                post("pointerMoved", place);
                break;
        }
        if (event.pointerType === "touch" && phase >= 2) {
            finger = null;
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
        act();
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
}

/// Text is edited at this place, or nowhere: input methods and screen keyboards want an element there.
export function edit(rect) {
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
}

export async function copyText(words) {
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
