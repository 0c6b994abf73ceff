//! The words of commands.

/// The commands: the word, its arguments, and what it does.
pub const WORDS: &[(&str, &str, &str)] = &[
    (
        "open",
        "KEY=VALUE …",
        "opens a scene with the keys of a link (or a link), runs it to its end, and resets the panels",
    ),
    ("pixel", "X,Y", "selects the ray of a pixel"),
    (
        "find",
        "VALUE = VALUE, …",
        "selects the ray nearest to that pixel, or to the middle of the image, for which all of this holds, and whose history on this device has the `row` of the step; only values of `tie`",
    ),
    ("start", "", "goes to before the first pass"),
    ("pass", "N", "goes to after pass N"),
    ("end", "", "goes to after the last pass"),
    ("row", "[N] \"TEXT\"", "goes to the pass of the ray's first (or N-th) row whose *why* contains the text"),
    (
        "only",
        "PANEL … / PANEL …",
        "shows exactly these panels, in rows from top to bottom, separated by a slash; what `do` did before is not repeated",
    ),
    ("show", "PANEL", "shows one more panel, in a row at the bottom"),
    ("stream", "NAME[.LAYER]", "shows a stream in the stream panel, as a whole"),
    ("zoom", "N [at X,Y]", "enlarges it to N points a texel, around a pixel, or the selected one"),
    ("do", "COMMAND", "performs a command of the menus"),
    (
        "measure",
        "NAME KEY=VALUE …",
        "traces the open scene with other options, on the same device, two to four times, and keeps the fastest after the first",
    ),
    ("bars", "NAME …", "shows measured runs next to each other in the lesson"),
    ("candidates", "", "shows the triangles that the ray may hit, in f32 and in f64, in the lesson"),
    (
        "before-after",
        "[axis] [cell] [tmax] [state]",
        "shows the ray before its next step from cell to cell, or the one just made, in the lesson; of what comes after a step that is not made yet, only the named parts",
    ),
    (
        "states",
        "",
        "shows the states of a ray, the kernels between them, and which of them this ray takes, in the lesson",
    ),
    ("code", "FUNCTION", "marks a function in the kernel panel"),
    ("play", "N", "goes on by itself, pass by pass of the ray, until it has made N more steps from cell to cell"),
    ("question", "\"TEXT\"", "asks the reader a question; the rest of the step is its answer"),
    (
        "choice",
        "\"LABEL\" if VALUE = VALUE, … else \"TEXT\"",
        "a choice, what holds if it is right, and what a reader is told who chooses it although it is wrong",
    ),
    ("expect", "panel PANEL", "the panel has to be in view"),
    ("expect", "text \"TEXT\"", "the text has to be readable outside of the lesson"),
    ("expect", "VALUE = VALUE", "values have to compare so; also !=, <, >, and `contains`"),
];

/// The words of all commands, for errors.
pub(super) fn names() -> String {
    let mut words: Vec<&str> = WORDS.iter().map(|(word, ..)| *word).collect();
    words.dedup();
    words.join(", ")
}
