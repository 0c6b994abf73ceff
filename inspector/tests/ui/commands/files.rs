//! Files that commands have saved.

use raystep_inspector::command::PaneKind;

use super::effects::is_shown;
use crate::ui::stage::Stage;

/// Saved files whose names end with `end`.
pub(super) fn saved(stage: &Stage, end: &str) -> Vec<Vec<u8>> {
    let desk = stage.desk.lock().expect("not poisoned");
    desk.saved.iter().filter(|file| file.name.ends_with(end)).map(|file| file.bytes.clone()).collect()
}

/// The only saved file.
#[track_caller]
pub(super) fn file(stage: &mut Stage, end: &str) -> Vec<u8> {
    stage.settle();
    let mut files = saved(stage, end);
    let all = stage.desk.lock().expect("not poisoned").saved.len();
    assert_eq!((files.len(), all), (1, 1), "expected one file *{end}");
    files.remove(0)
}

/// A drawing was saved, and its panel is visible.
#[track_caller]
pub(super) fn drawing(stage: &mut Stage, kind: PaneKind) {
    stage.settle();
    is_shown(stage, kind);
    let text = String::from_utf8(file(stage, ".svg")).expect("text");
    assert!(text.contains("<svg") && text.trim_end().ends_with("</svg>") && text.len() > 500, "{text}");
}
