//! Text that can be read: at least 4.5:1 against the window, and 11 points high.

use std::sync::Arc;

use egui::{
    Color32, FontData, FontDefinitions, FontFamily, FontId, FontTweak, Response, RichText, Style, TextStyle, Theme, Ui,
};

/// The smallest text, in points.
pub(in crate::ui) const SMALLEST: f32 = 11.0;

/// Shades of normal and weak text, by theme. Weak text has about 6:1 against the panels of either theme.
fn shades(theme: Theme) -> [u8; 2] {
    match theme {
        Theme::Dark => [195, 155],
        Theme::Light => [45, 95],
    }
}

/// Headings of tables and dialogs, and what a panel found.
const STRONG: &str = "strong";

/// Inter (Rasmus Andersson), regular and semibold, before egui's own fonts, which have the symbols that it lacks.
fn fonts() -> FontDefinitions {
    let mut fonts = FontDefinitions::default();
    let others = fonts.families.get(&FontFamily::Proportional).cloned().unwrap_or_default();
    // Its letters are larger than those of egui's fonts, for which sizes were chosen.
    // Hinted at such sizes, a dot would touch its letter.
    let tweak = FontTweak { scale: 0.94, hinting: Some(false), ..FontTweak::default() };
    for (family, name, bytes) in [
        (FontFamily::Proportional, "Inter", &include_bytes!("fonts/Inter-Regular.ttf")[..]),
        (FontFamily::Name(STRONG.into()), "Inter SemiBold", &include_bytes!("fonts/Inter-SemiBold.ttf")[..]),
    ] {
        fonts.font_data.insert(name.into(), Arc::new(FontData::from_static(bytes).tweak(tweak.clone())));
        fonts.families.insert(family, std::iter::once(name.into()).chain(others.iter().cloned()).collect());
    }
    fonts
}

/// Text that stands out, such as a heading or what a panel found.
pub(in crate::ui) fn strong(ui: &mut Ui, text: impl Into<String>) -> Response {
    ui.label(in_strong(text))
}

/// The same, for other widgets than labels.
pub(in crate::ui) fn in_strong(text: impl Into<String>) -> RichText {
    RichText::new(text).strong().family(FontFamily::Name(STRONG.into()))
}

/// Sets the fonts, and the style of both themes.
pub(super) fn set(ctx: &egui::Context) {
    ctx.set_fonts(fonts());
    for theme in [Theme::Dark, Theme::Light] {
        ctx.style_mut_of(theme, |style| adapt(style, theme));
    }
}

/// The colour that the window is cleared with: no panel paints a background of its own, which would double the work of a
/// software renderer.
#[must_use]
pub fn background(ctx: &egui::Context) -> egui::Color32 {
    ctx.global_style().visuals.panel_fill
}

fn adapt(style: &mut Style, theme: Theme) {
    let [normal, weak] = shades(theme).map(Color32::from_gray);
    style.visuals.widgets.noninteractive.fg_stroke.color = normal;
    style.visuals.weak_text_color = Some(weak);
    if theme == Theme::Light {
        style.visuals.hyperlink_color = Color32::from_rgb(0, 90, 190);
        // Selected text, also in the shadow of a menu.
        style.visuals.selection.stroke.color = Color32::from_rgb(0, 55, 95);
    }
    style.text_styles.insert(TextStyle::Small, FontId::proportional(SMALLEST));
    style.text_styles.insert(TextStyle::Heading, FontId::new(16.0, FontFamily::Name(STRONG.into())));
}

/// Black or white, whichever is easier to read on a fill: at least 4.5:1 on any.
pub(super) fn ink_on(fill: Color32) -> Color32 {
    let is_black = contrast(Color32::BLACK, fill) >= contrast(Color32::WHITE, fill);
    if is_black { Color32::BLACK } else { Color32::WHITE }
}

/// A colour moved towards another one, by a part from 0 to 1.
pub(super) fn towards(from: Color32, to: Color32, part: f32) -> Color32 {
    let mix = |a: u8, b: u8| (f32::from(a) + (f32::from(b) - f32::from(a)) * part).round() as u8;
    Color32::from_rgb(mix(from.r(), to.r()), mix(from.g(), to.g()), mix(from.b(), to.b()))
}

/// Relative luminance (WCAG 2.1).
fn luminance(color: Color32) -> f64 {
    let [r, g, b] = [color.r(), color.g(), color.b()].map(|part| {
        let part = f64::from(part) / 255.0;
        if part <= 0.04045 { part / 12.92 } else { ((part + 0.055) / 1.055).powf(2.4) }
    });
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// Contrast of two opaque colours (WCAG 2.1).
pub(super) fn contrast(a: Color32, b: Color32) -> f64 {
    let (a, b) = (luminance(a), luminance(b));
    (a.max(b) + 0.05) / (a.min(b) + 0.05)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_can_be_read_on_every_background_of_both_themes() {
        for theme in [Theme::Dark, Theme::Light] {
            let mut style = Style { visuals: theme.default_visuals(), ..Style::default() };
            adapt(&mut style, theme);
            let visuals = &style.visuals;
            let stripe = visuals.panel_fill.blend(visuals.faint_bg_color);
            for text in [visuals.text_color(), visuals.weak_text_color(), visuals.strong_text_color()] {
                for background in [visuals.panel_fill, stripe, visuals.extreme_bg_color, visuals.window_fill] {
                    let ratio = contrast(text, background);
                    assert!(ratio >= 4.5, "{theme:?}: {text:?} on {background:?} has {ratio:.2}:1");
                }
            }
            assert!(style.text_styles.values().all(|font| font.size >= SMALLEST), "{:?}", style.text_styles);
        }
    }

    #[test]
    fn ink_can_be_read_on_every_fill() {
        let all = (0..=255).step_by(15).flat_map(|r| (0..=255).step_by(15).map(move |g| (r, g)));
        for (r, g) in all {
            for b in [0, 90, 180, 255] {
                let fill = Color32::from_rgb(r, g, b);
                assert!(contrast(ink_on(fill), fill) >= 4.5, "{fill:?}");
            }
        }
    }
}
