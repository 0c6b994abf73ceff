// The panel over the canvas: a question, a wait, or the end.

const panel = document.getElementById("panel");
const message = document.getElementById("message");
const buttons = document.getElementById("buttons");
const progress = document.getElementById("progress");

export function show(line, actions = [], isWaiting = false) {
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

export function hide() {
    panel.hidden = true;
    document.getElementById("canvas").focus();
}

export const isHidden = () => panel.hidden;

/// Nothing can be shown: what is missing, and how it would look.
export function showPictures(why) {
    show(`raystep cannot run in this browser: ${why}.`);
    const pictures = document.getElementById("pictures");
    for (const [file, caption] of [
        ["step.png", "The inspector: an image, its passes, and the streams between them"],
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
