// Files that the user gives to the page.

const chooser = document.getElementById("chooser");

/// Has the user choose files with one of these endings.
export function choose(endings) {
    chooser.accept = endings;
    chooser.value = "";
    chooser.click();
}

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

/// Calls `give` with the paths and the files of every choice and drop, `cancel` if nothing was chosen, and `go` with a link
/// that was dropped.
export function listen({ give, cancel, go }) {
    chooser.addEventListener("change", () => give(Array.from(chooser.files, (file) => [file.name, file])));
    chooser.addEventListener("cancel", cancel);
    document.addEventListener("dragover", (event) => event.preventDefault());
    document.addEventListener("drop", async (event) => {
        event.preventDefault();
        const text = event.dataTransfer.getData("text/plain");
        const entries = Array.from(event.dataTransfer.items, (item) => item.webkitGetAsEntry?.()).filter(Boolean);
        const plain = Array.from(event.dataTransfer.files, (file) => [file.name, file]);
        if (entries.length > 0) {
            give((await Promise.all(entries.map((entry) => filesOf(entry)))).flat());
        } else if (plain.length > 0) {
            give(plain);
        } else if (text.startsWith("raystep:")) {
            go(text);
        }
    });
}
