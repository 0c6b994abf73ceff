//! The size of all text: egui's zoom factor, in steps, on top of the window's own scale.

use crate::command::Command;

/// The factors that the commands step through.
const STEPS: [f32; 13] = [0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.25, 1.5, 1.75, 2.0, 2.5, 3.0];

/// The next larger or smaller step; the same factor at either end.
fn next(factor: f32, is_larger: bool) -> f32 {
    // A thousandth: a factor that was written as text and read again is still the same step.
    let found = match is_larger {
        true => STEPS.iter().find(|step| **step > factor + 1e-3),
        false => STEPS.iter().rfind(|step| **step < factor - 1e-3),
    };
    found.copied().unwrap_or(factor)
}

/// Sets the saved factor, and leaves its keys to the table of commands.
pub(super) fn set_up(ctx: &egui::Context, factor: f32) {
    ctx.options_mut(|options| options.zoom_with_keyboard = false);
    ctx.set_zoom_factor(factor);
}

/// The factor after a command about the size of text.
pub(super) fn resized(command: Command, factor: f32) -> f32 {
    match command {
        Command::LargerText => next(factor, true),
        Command::SmallerText => next(factor, false),
        _ => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_end_at_half_and_three_times_the_size() {
        let mut factor = 1.0;
        (0..20).for_each(|_| factor = next(factor, true));
        assert_eq!((factor, next(factor, false)), (3.0, 2.5));
        (0..20).for_each(|_| factor = next(factor, false));
        assert_eq!((factor, next(factor, true)), (0.5, 0.6));
        // Between two steps, in either direction.
        assert_eq!((next(1.3, true), next(1.3, false)), (1.5, 1.25));
        assert_eq!([STEPS[0], STEPS[STEPS.len() - 1]], crate::saved::TEXT_SIZES);
    }
}
