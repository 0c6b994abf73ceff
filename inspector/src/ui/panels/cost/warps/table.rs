//! The slowest warps, and what held them.

use egui::{Align, Label, Layout, RichText, Ui};
use egui_extras::{Column, TableBuilder};
use raystep_lab::work::Warp;

use super::super::rays::pixel_of;
use super::super::source::Counts;
use crate::ui::style::strong;

/// Heads of the columns.
const HEADS: [(&str, &str); 7] = [
    ("#", "1 took the most passes"),
    ("first pixel", "the pixel of the warp's first ray; click to select its slowest ray and to frame its pixels"),
    ("passes", "passes of the walk that worked on any of its rays"),
    ("useful", "share of its lanes that had work, over these passes"),
    ("sparse", "passes in which fewer than a quarter of its lanes had work"),
    ("held by", "the ray with the most passes: the others waited for it"),
    ("median", "passes of the median ray"),
];

/// Shows the list; returns the warp that was clicked.
pub(super) fn show(ui: &mut Ui, warps: &[Warp], selected: Option<usize>, width: u32) -> Option<usize> {
    let height = ui.text_style_height(&egui::TextStyle::Body) + 4.0;
    let mut clicked = None;
    TableBuilder::new(ui)
        .id_salt("warps")
        .striped(true)
        .sense(egui::Sense::click())
        .auto_shrink(false)
        .cell_layout(Layout::right_to_left(Align::Center))
        .columns(Column::auto().at_least(34.0), HEADS.len() - 1)
        .column(Column::remainder().at_least(60.0))
        .header(height, |mut header| {
            for (head, about) in HEADS {
                header.col(|ui| drop(strong(ui, head).on_hover_text(about)));
            }
        })
        .body(|body| {
            body.rows(height, warps.len(), |mut row| {
                let at = row.index();
                let warp = &warps[at];
                row.set_selected(selected == Some(at));
                for cell in cells(at, warp, width) {
                    row.col(|ui| {
                        drop(ui.add(Label::new(RichText::new(cell).monospace()).selectable(false).extend()));
                    });
                }
                if row.response().clicked() {
                    clicked = Some(at);
                }
            });
        });
    clicked
}

fn cells(at: usize, warp: &Warp, width: u32) -> [String; 7] {
    let pixel = |ray: u32| {
        let [x, y] = pixel_of(ray as usize, width);
        format!("{x},{y}")
    };
    [
        (at + 1).to_string(),
        warp.rays.first().map_or_else(String::new, |&ray| pixel(ray)),
        warp.passes.to_string(),
        format!("{:.1}%", warp.useful * 100.0),
        warp.sparse.to_string(),
        pixel(warp.slowest),
        warp.median_passes.to_string(),
    ]
}

/// What held a warp, in sentences.
pub(super) fn reason(warp: &Warp, counts: Option<&Counts>, width: u32) -> String {
    let [x, y] = pixel_of(warp.slowest as usize, width);
    let work = |of: fn(&Counts) -> &Vec<u32>| counts.and_then(|counts| of(counts).get(warp.slowest as usize));
    let work = match work(|c| &c.cells).zip(work(|c| &c.triangles)) {
        Some((cells, triangles)) => format!(" ({cells} cells or nodes, {triangles} triangles)"),
        None => String::new(),
    };
    format!(
        "Held by pixel {x},{y}: {} of {} passes worked on it{work}; the median of the {} rays had {}. In {} passes \
         fewer than a quarter of the lanes had work.",
        warp.slowest_passes,
        warp.passes,
        warp.rays.len(),
        warp.median_passes,
        warp.sparse
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_warp_is_told_with_the_ray_that_held_it() {
        let warp = Warp {
            rays: vec![9, 10, 11],
            passes: 7,
            sparse: 4,
            useful: 0.25,
            slowest: 11,
            slowest_passes: 6,
            median_passes: 2,
        };
        assert_eq!(cells(0, &warp, 8), ["1", "1,1", "7", "25.0%", "4", "3,1", "2"]);
        let counts = Counts { cells: (0..12).collect(), triangles: vec![5; 12] };
        let reason_text = reason(&warp, Some(&counts), 8);
        assert!(reason_text.starts_with("Held by pixel 3,1: 6 of 7 passes worked on it (11 cells or nodes, 5 triangles); the median of the 3 rays had 2."), "{reason_text}");
        assert!(reason(&warp, None, 8).starts_with("Held by pixel 3,1: 6 of 7 passes worked on it; the median"));
    }
}
