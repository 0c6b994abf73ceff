//! What `worker.js` provides: a clock, timers, and the page.

use js_sys::{Function, Uint8Array};
use wasm_bindgen::prelude::*;

#[wasm_bindgen(js_namespace = raystep)]
extern "C" {
    /// Milliseconds since the page was opened.
    pub(crate) fn now() -> f64;

    /// Has `Window::frame` called after this many milliseconds; 0 is the next frame of the display.
    pub(crate) fn wake(after_ms: f64);

    /// Has `work` called once events have been served.
    pub(crate) fn later();

    /// Sets the pointer's shape, by its name in CSS.
    pub(crate) fn cursor(name: &str);

    /// Puts a text on the clipboard.
    pub(crate) fn copy(text: &str);

    /// Opens an address in another tab.
    pub(crate) fn visit(url: &str);

    /// Where text is edited, in CSS pixels: left, top, width, height of the cursor. Empty if nowhere.
    pub(crate) fn editing(rect: &[f32]);

    /// Sets the page's title.
    pub(crate) fn title(text: &str);

    /// Puts a link into the page's address.
    pub(crate) fn address(link: &str);

    /// Stores settings for the next visit.
    pub(crate) fn keep(saved: &str);

    /// Saves a file among the downloads.
    pub(crate) fn download(name: &str, bytes: Uint8Array);

    /// Has the user choose files; `Window::files` gets them, or `Window::cancelled` is called.
    pub(crate) fn choose(endings: &str);

    /// Asks for a file by its name, among files with these endings; an empty name takes the question back.
    pub(crate) fn ask_for(name: &str, endings: &str);

    /// Tells assistive technology.
    pub(crate) fn tell(text: &str);

    /// Fetches a file of at most so many bytes. `progress` gets the bytes so far and in total, 0 if that is not known,
    /// and returns whether to go on. Rejects with a text.
    #[wasm_bindgen(catch)]
    pub(crate) async fn fetch(url: &str, most_bytes: f64, progress: &Function) -> Result<JsValue, JsValue>;
}

/// A clock in nanoseconds.
pub(crate) fn now_ns() -> u64 {
    (now() * 1e6) as u64
}

/// The text of something that JavaScript threw.
pub(crate) fn reason(thrown: &JsValue) -> String {
    let message = js_sys::Reflect::get(thrown, &"message".into()).ok().and_then(|message| message.as_string());
    message.or_else(|| thrown.as_string()).unwrap_or_else(|| "the browser gives no reason".into())
}
