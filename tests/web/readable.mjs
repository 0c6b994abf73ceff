// Whether the text of a page can be read: its contrast, and whether it is cut off. What is drawn on the canvas is checked in
// inspector/tests/ui/readable.rs.

/// Contrast of normal text (WCAG 2.1, 1.4.3, level AA).
const LEAST_CONTRAST = 4.5;

/// A wide window, and a phone's.
const SIZES = [
    { width: 1280, height: 800 },
    { width: 320, height: 568 },
];

/// The texts that cannot be read in either size and theme, each with the reason.
export async function unreadable(page) {
    const [found, before] = [[], page.viewportSize()];
    for (const size of SIZES) {
        await page.setViewportSize(size);
        for (const colorScheme of ["light", "dark"]) {
            await page.emulateMedia({ colorScheme });
            const texts = await page.evaluate(unreadableNow, LEAST_CONTRAST);
            found.push(...texts.map((text) => `${size.width} pixels, ${colorScheme}: ${text}`));
        }
    }
    await page.setViewportSize(before);
    return found;
}

/// In the page.
function unreadableNow(leastContrast) {
    // As the browser converts it, also from other colour spaces.
    const context = Object.assign(document.createElement("canvas"), { width: 1, height: 1 }).getContext("2d", { willReadFrequently: true });
    const rgba = (css) => {
        context.clearRect(0, 0, 1, 1);
        context.fillStyle = css;
        context.fillRect(0, 0, 1, 1);
        const [r, g, b, a] = context.getImageData(0, 0, 1, 1).data;
        return [r, g, b, a / 255];
    };
    const over = ([r, g, b, a], below) => [...[r, g, b].map((c, i) => a * c + (1 - a) * below[i]), 1];
    const background = (element) => (element === null ? [255, 255, 255, 1] : over(rgba(getComputedStyle(element).backgroundColor), background(element.parentElement)));
    const luminance = (color) => {
        const [r, g, b] = color.map((c) => (c / 255 <= 0.04045 ? c / 255 / 12.92 : ((c / 255 + 0.055) / 1.055) ** 2.4));
        return 0.2126 * r + 0.7152 * g + 0.0722 * b;
    };
    const found = [];
    const nodes = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    while (nodes.nextNode()) {
        const [text, element] = [nodes.currentNode.data.trim(), nodes.currentNode.parentElement];
        // Some texts are for screen readers alone.
        const isShown = element.checkVisibility({ opacityProperty: true, visibilityProperty: true }) && element.closest("#told, script, style, noscript") === null;
        if (text === "" || !isShown) {
            continue;
        }
        const below = background(element);
        const [a, b] = [luminance(over(rgba(getComputedStyle(element).color), below)), luminance(below)];
        const contrast = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
        if (contrast < leastContrast) {
            found.push(`${JSON.stringify(text)} has ${contrast.toFixed(2)}:1`);
        }
        const range = document.createRange();
        range.selectNodeContents(nodes.currentNode);
        // What scrolls to the sides by itself, as a listing does, may be wider.
        const scrolls = (e) => e !== null && e !== document.body && (/auto|scroll/.test(getComputedStyle(e).overflowX) && e.id !== "panel" || scrolls(e.parentElement));
        const { left, right } = range.getBoundingClientRect();
        if ((left < -0.5 || right > innerWidth + 0.5) && !scrolls(element)) {
            found.push(`${JSON.stringify(text)} is cut off: from ${left} to ${right} of ${innerWidth}`);
        }
    }
    return found;
}
