// Serves the page and drives it in Chromium.

import { createReadStream, existsSync, statSync } from "node:fs";
import http from "node:http";
import { createRequire } from "node:module";
import path from "node:path";
import { fileURLToPath } from "node:url";

// By NODE_PATH, which only `require` looks at.
const { chromium } = createRequire(import.meta.url)("playwright-core");

const root = path.join(path.dirname(fileURLToPath(import.meta.url)), "../..");
const target = path.join(process.env.CARGO_TARGET_DIR ?? path.join(root, "target"), "web");
export const served = process.env.RAYSTEP_PAGE ?? path.join(target, "served");
export const scenes = path.join(root, "scenes");

const TYPES = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".png": "image/png" };

/// A plain file server, without compression or special headers.
export function serve() {
    const server = http.createServer((request, response) => {
        const name = decodeURIComponent(new URL(request.url, "http://localhost").pathname);
        const file = path.join(served, name.endsWith("/") ? `${name}index.html` : name);
        if (!file.startsWith(served) || !existsSync(file)) {
            response.writeHead(404).end();
            return;
        }
        const type = TYPES[path.extname(file)] ?? "application/octet-stream";
        response.writeHead(200, { "content-type": type, "content-length": statSync(file).size });
        createReadStream(file).pipe(response);
    });
    return new Promise((resolve) => server.listen(0, () => resolve(server)));
}

const SOFTWARE = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"];

/// What there is to draw and compute with: in software, since a test machine has no GPU.
export const WAYS = {
    webgpu: [...SOFTWARE, "--enable-unsafe-webgpu", "--enable-features=Vulkan", "--use-vulkan=swiftshader"],
    webgl: SOFTWARE,
    nothing: ["--disable-gpu", "--disable-software-rasterizer"],
};

/// A browser that serves one way of drawing, and the pages opened in it.
export class Browser {
    static async open(way) {
        const own = new Browser();
        own.server = await serve();
        own.chromium = await chromium.launch({
            executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
            headless: false,
            args: ["--no-sandbox", ...WAYS[way]],
        });
        return own;
    }

    /// Opens the page at a link, in a tab of its own.
    async page(link = "", query = "") {
        const page = await this.chromium.newPage({ viewport: { width: 1280, height: 800 }, acceptDownloads: true });
        const tab = new Tab(page);
        page.on("console", (message) => message.type() === "error" && tab.troubles.push(message.text()));
        page.on("pageerror", (error) => tab.troubles.push(String(error)));
        await page.goto(`http://localhost:${this.server.address().port}/${query}${link ? `#${link}` : ""}`);
        return tab;
    }

    async close() {
        await this.chromium.close();
        this.server.close();
    }
}

/// An open page.
export class Tab {
    constructor(page) {
        this.page = page;
        /// Errors in the console.
        this.troubles = [];
    }

    /// Waits until the inspector is there.
    async ready() {
        await this.page.waitForFunction(() => window.raystep?.isReady || window.raystep?.failure, null, { timeout: 120_000 });
        const failure = await this.page.evaluate(() => window.raystep.failure);
        if (failure !== undefined) {
            throw new Error(failure);
        }
    }

    /// Waits until nothing is left to do; what is shown then. The worker answers after all events before the question.
    async settled() {
        await this.ready();
        for (let calm = 0, begin = Date.now(); ; ) {
            const state = await this.state();
            calm = state.busy ? 0 : calm + 1;
            if (calm === 3) {
                return state;
            }
            if (Date.now() - begin > 180_000) {
                throw new Error(`still busy: ${JSON.stringify(state)}`);
            }
            await this.page.waitForTimeout(40);
        }
    }

    state() {
        return this.page.evaluate(() => window.raystep.state());
    }

    async press(...keys) {
        for (const key of keys) {
            await this.page.keyboard.press(key);
        }
        return this.settled();
    }

    /// Performs a command by its name.
    async perform(name) {
        await this.press("Control+p");
        await this.page.keyboard.type(name);
        await this.settled();
        await this.press("Enter");
    }

    async go(link) {
        await this.page.evaluate((link) => window.raystep.go(link), link);
        return this.settled();
    }

    screenshot(name) {
        return this.page.screenshot({ path: path.join(target, "screenshots", `${name}.png`) });
    }

    /// Drops files: names and contents.
    drop(files) {
        return this.page.evaluate((files) => {
            const transfer = new DataTransfer();
            for (const [name, base64] of files) {
                const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
                transfer.items.add(new File([bytes], name));
            }
            document.dispatchEvent(new DragEvent("drop", { dataTransfer: transfer, cancelable: true, bubbles: true }));
        }, files.map(([name, bytes]) => [name, Buffer.from(bytes).toString("base64")]));
    }
}

/// The value of a key of a link.
export const keyOf = (link, key) => new URLSearchParams(link.split("?")[1]).get(key);
