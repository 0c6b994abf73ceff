//! What egui paints, as an SVG drawing: lines, filled shapes and texts.

use std::cell::RefCell;

use egui::epaint::{ColorMode, PathShape, RectShape, TextShape};
use egui::{Color32, Context, Frame, Painter, Pos2, RawInput, Rect, Shape, Stroke, StrokeKind, Theme, Ui, vec2};
use svg::node::element::{Circle, ClipPath, Group, Line, Path, Polygon, Rectangle, Text, Title};
use svg::{Document, Node};

use super::style;

/// egui's font first, then others that are hardly wider: not every viewer makes a text as wide as it is told.
const SANS_SERIF: &str = "Inter,Ubuntu,'Segoe UI',Helvetica,Arial,sans-serif";
/// The height of a page, in points: a drawing is as high as its contents.
const HIGHEST: f32 = 20_000.0;

/// What a viewer of the file tells of the areas under the cursor; later ones lie over earlier ones.
#[derive(Default)]
pub(super) struct Titles(RefCell<Vec<Titled>>);

/// What clips an area, the area, and its text.
type Titled = (Rect, Shape, String);

impl Titles {
    /// The text of an area, as far as the painter paints it.
    pub(super) fn add(&self, painter: &Painter, area: Shape, text: String) {
        self.0.borrow_mut().push((painter.clip_rect(), area, text));
    }
}

/// An SVG file of this width, in points, with what `draw` adds to a page in the style of the window.
pub(super) fn drawing(width: f32, is_dark: bool, mut draw: impl FnMut(&mut Ui, &Titles)) -> String {
    let ctx = Context::default();
    style::set(&ctx);
    ctx.set_theme(if is_dark { Theme::Dark } else { Theme::Light });
    let page = Rect::from_min_size(Pos2::ZERO, vec2(width, HIGHEST));
    let (titles, mut height) = (Titles::default(), 0.0);
    let mut frame = || {
        titles.0.borrow_mut().clear();
        let mut output = ctx.run_ui(RawInput { screen_rect: Some(page), ..RawInput::default() }, |ui| {
            Frame::NONE.inner_margin(12.0).show(ui, |ui| {
                draw(ui, &titles);
                height = ui.min_rect().bottom() + 12.0;
            });
        });
        // No renderer takes the font.
        output.textures_delta.clear();
        output.shapes
    };
    // Sizes are known after the first frame.
    frame();
    let shapes = frame();
    let [width, height] = [width, height].map(n);
    let mut document = Document::new()
        .set("width", width)
        .set("height", height)
        .set("viewBox", format!("0 0 {width} {height}"))
        .add(Rectangle::new().set("width", width).set("height", height).set("fill", hex(style::background(&ctx))));
    let mut groups: Vec<(Rect, Group)> = Vec::new();
    for of_clip in shapes.chunk_by(|a, b| a.clip_rect == b.clip_rect) {
        let mut group = Group::new();
        of_clip.iter().for_each(|clipped| add(&mut group, &clipped.shape));
        groups.push((of_clip[0].clip_rect, group));
    }
    for of_clip in titles.0.take().chunk_by(|a, b| a.0 == b.0) {
        let mut group = Group::new().set("opacity", 0);
        for (_, area, text) in of_clip {
            let mut titled = Group::new().add(Title::new(printable(text)));
            add(&mut titled, area);
            group.append(titled);
        }
        groups.push((of_clip[0].0, group));
    }
    for (i, (clip, group)) in groups.into_iter().enumerate() {
        let id = format!("clip{i}");
        let group = group.set("clip-path", format!("url(#{id})"));
        document = document.add(ClipPath::new().set("id", id).add(rectangle(clip.intersect(page)))).add(group);
    }
    format!("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n{document}\n")
}

fn add(group: &mut Group, shape: &Shape) {
    match shape {
        Shape::Vec(shapes) => shapes.iter().for_each(|shape| add(group, shape)),
        Shape::LineSegment { points: [a, b], stroke } => {
            let line = Line::new().set("x1", n(a.x)).set("y1", n(a.y)).set("x2", n(b.x)).set("y2", n(b.y));
            group.append(painted(line, Color32::TRANSPARENT, *stroke));
        }
        Shape::Circle(circle) => {
            let Pos2 { x, y } = circle.center;
            let element = Circle::new().set("cx", n(x)).set("cy", n(y)).set("r", n(circle.radius));
            group.append(painted(element, circle.fill, circle.stroke));
        }
        Shape::Path(path) => add_path(group, path),
        Shape::Rect(rect) => add_rect(group, rect),
        Shape::Text(text) => add_text(group, text),
        // Pictures and meshes are no drawings.
        _ => {}
    }
}

fn add_path(group: &mut Group, path: &PathShape) {
    let points: Vec<String> = path.points.iter().map(|p| format!("{},{}", n(p.x), n(p.y))).collect();
    let color = if let ColorMode::Solid(color) = path.stroke.color { color } else { Color32::TRANSPARENT };
    let stroke = Stroke::new(path.stroke.width, color);
    if path.closed {
        group.append(painted(Polygon::new().set("points", points.join(" ")), path.fill, stroke));
    } else {
        group.append(painted(Path::new().set("d", format!("M{}", points.join("L"))), path.fill, stroke));
    }
}

fn add_rect(group: &mut Group, shape: &RectShape) {
    let by = match shape.stroke_kind {
        StrokeKind::Inside => -0.5,
        StrokeKind::Middle => 0.0,
        StrokeKind::Outside => 0.5,
    };
    let rect = rectangle(shape.rect.expand(by * shape.stroke.width));
    let rect = rect.set("rx", n(shape.corner_radius.average().min(0.5 * shape.rect.height())));
    group.append(painted(rect, shape.fill, shape.stroke));
}

/// Each row of a text, in the format of its first letter.
fn add_text(group: &mut Group, shape: &TextShape) {
    let (sections, mut at) = (&shape.galley.job.sections, 0);
    for row in &shape.galley.rows {
        let letters: String = row.row.glyphs.iter().map(|glyph| glyph.chr).collect();
        let last = row.row.glyphs.iter().rfind(|glyph| !glyph.chr.is_whitespace());
        let section = sections.iter().find(|section| section.byte_range.end.0 > at).or(sections.last());
        at += letters.len() + usize::from(row.ends_with_newline);
        let (Some(first), Some(last), Some(section)) = (row.row.glyphs.first(), last, section) else { continue };
        let place = shape.pos + row.pos.to_vec2() + first.pos.to_vec2();
        let color = match section.format.color {
            Color32::PLACEHOLDER => shape.fallback_color,
            color => color,
        };
        let is_code = section.format.font_id.family == egui::FontFamily::Monospace;
        // As wide as in egui's font, whatever font the viewer has: boxes are made for it.
        let text = Text::new(printable(letters.trim_end()))
            .set("textLength", n(last.max_x() - first.pos.x))
            .set("lengthAdjust", "spacingAndGlyphs")
            .set("x", n(place.x))
            .set("y", n(place.y))
            .set("font-size", n(section.format.font_id.size))
            .set("font-family", if is_code { "monospace" } else { SANS_SERIF });
        group.append(painted(text, shape.override_text_color.unwrap_or(color), Stroke::NONE));
    }
}

/// XML does not allow control characters other than line ends.
fn printable(text: &str) -> String {
    text.replace(|c: char| c.is_control() && c != '\n', " ")
}

/// An element with its fill and stroke.
fn painted<E: Node>(mut element: E, fill: Color32, stroke: Stroke) -> E {
    paint(&mut element, "fill", fill);
    if stroke.width > 0.0 && stroke.color != Color32::TRANSPARENT {
        paint(&mut element, "stroke", stroke.color);
        element.assign("stroke-width", n(stroke.width));
    }
    element
}

fn paint(element: &mut impl Node, what: &str, color: Color32) {
    if color == Color32::TRANSPARENT {
        element.assign(what, "none");
        return;
    }
    element.assign(what, hex(color));
    if color.a() < u8::MAX {
        element.assign(format!("{what}-opacity"), n(f32::from(color.a()) / 255.0));
    }
}

fn hex(color: Color32) -> String {
    let [r, g, b, _] = color.to_srgba_unmultiplied();
    format!("#{r:02x}{g:02x}{b:02x}")
}

fn rectangle(rect: Rect) -> Rectangle {
    let [x, y, width, height] = [rect.left(), rect.top(), rect.width().max(0.0), rect.height().max(0.0)].map(n);
    Rectangle::new().set("x", x).set("y", y).set("width", width).set("height", height)
}

/// A number with the precision that a drawing needs.
fn n(value: f32) -> f32 {
    // No drawing is that large; SVG has no infinities or NaN.
    let value = if value.is_finite() { value.clamp(-1e6, 1e6) } else { 0.0 };
    (value * 100.0).round() / 100.0
}

#[cfg(test)]
mod tests {
    use egui::{Align2, FontId, pos2};

    use super::*;

    #[test]
    fn what_is_painted_is_in_the_file_and_every_element_is_closed() {
        let text = drawing(300.0, false, |ui, titles| {
            ui.label("a <b> & \u{1}c");
            let painter = ui.painter().with_clip_rect(Rect::from_min_size(Pos2::ZERO, vec2(50.0, 60.0)));
            painter.circle(pos2(20.0, f32::NAN), 4.0, Color32::RED, Stroke::new(2.0, Color32::from_black_alpha(51)));
            painter.rect_filled(Rect::from_min_size(pos2(1.0, 2.0), vec2(3.0, 4.0)), 1.0, Color32::BLUE);
            titles.add(
                &painter,
                Shape::circle_filled(pos2(7.0, 8.0), 3.0, Color32::BLACK),
                "a <dot>\u{1}\nin two lines".into(),
            );
            painter.line_segment([pos2(1.0, 1.0), pos2(2.5, 3.0)], Stroke::new(1.0, Color32::GREEN));
            painter.text(pos2(9.0, 9.0), Align2::LEFT_TOP, "two\nrows", FontId::monospace(11.0), Color32::BLACK);
            let corners = vec![pos2(0.0, 0.0), pos2(9.0, 0.0), pos2(0.0, 9.0)];
            painter.add(Shape::convex_polygon(corners, Color32::WHITE, Stroke::NONE));
        });
        let text = text.replace(">\n", ">").replace("\n<", "<");
        for wanted in [
            ">a &lt;b&gt; &amp;  c</text>",
            ">two</text>",
            ">rows</text>",
            "font-family=\"monospace\"",
            "cy=\"0\"",
            "fill=\"#ff0000\"",
            "stroke-opacity=\"0.2\"",
            "points=\"0,0 9,0 0,9\"",
            "x2=\"2.5\"",
            "fill=\"#0000ff\"",
        ] {
            assert!(text.contains(wanted), "{wanted}: {text}");
        }
        for nonsense in ["NaN", "inf", "\u{1}"] {
            assert!(!text.contains(nonsense), "{nonsense}");
        }
        // Once, although the page was drawn twice, within what it was clipped to, and over all else.
        let title = "<g><title>a &lt;dot&gt; \nin two lines</title><circle ";
        assert_eq!((text.matches(title).count(), text.matches("<title>").count()), (1, 1), "{text}");
        let (all, titles) = text.split_once(" opacity=\"0\">").expect("titles");
        assert!(all.contains(">two</text>") && titles.starts_with(title) && !titles.contains("<text"), "{text}");
        assert_eq!(text.matches("<rect height=\"60\" width=\"50\" ").count(), 2, "the clip of shapes and of titles");
        // Texts are as wide as in the window, where each letter is at a whole point.
        let width = |text: &str| text.rsplit_once("textLength=\"")?.1.split('"').next()?.parse::<f32>().ok();
        let [wide, narrow] = ["two", "rows"].map(|word| {
            let before = text.split(&format!(">{word}</text>")).next().expect("a text");
            width(before).expect("a width") / word.len() as f32
        });
        assert!((wide - narrow).abs() < 1.0 / 3.0 && wide > 5.0, "of a monospaced font: {wide} {narrow}");
        for element in ["g", "text", "svg", "circle", "clipPath", "title"] {
            let begun = |tag: &&str| tag.split([' ', '>']).next() == Some(element) && !tag.contains("/>");
            let ends = text.matches(&format!("</{element}>")).count();
            assert_eq!(text.split('<').filter(begun).count(), ends, "{element}");
        }
    }
}
