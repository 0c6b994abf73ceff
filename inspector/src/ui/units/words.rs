//! The reason of a row in other units: its words quote t in traced units.

use super::{Scale, Units};

/// Words after which a number is a t.
const BEFORE_T: [&str; 8] = ["t", "tmax.x", "tmax.y", "tmax.z", "exit", "t_min", "end", "than"];

/// The same sentence with every t converted. In traced units it is unchanged.
pub(in crate::ui) fn in_units(why: &str, scale: &Scale) -> String {
    if scale.units == Units::Traced {
        return why.to_owned();
    }
    let mut out = String::with_capacity(why.len());
    let mut before = "";
    for (i, word) in why.split(' ').enumerate() {
        if i > 0 {
            out.push(' ');
        }
        let number = word.trim_end_matches([',', ';', ':']);
        let is_t = BEFORE_T.contains(&before);
        match number.parse::<f32>() {
            Ok(t) if is_t && t.is_finite() => {
                out.push_str(&scale.exact_t(t));
                out.push_str(&word[number.len()..]);
            }
            _ => out.push_str(word),
        }
        before = word;
    }
    out
}

#[cfg(test)]
mod tests {
    use raystep_kernels::export::trace::RunSoFar;
    use raystep_kernels::plan::Plan;
    use raystep_kernels::{Accelerator, Limits, Numerics, Options, RaySource, ScheduleKind};
    use raystep_scenes::generate;

    use super::*;

    #[test]
    fn every_t_is_converted_and_nothing_else() {
        let scale = Scale::new(Units::Scene, 4.0, [0.0; 3], 4.0);
        for (traced, scene) in [
            (
                "tmax.z 0.5 is smallest: step +z to cell (3, 2, 5), which lists 12 triangles",
                "tmax.z 2 is smallest: step +z to cell (3, 2, 5), which lists 12 triangles",
            ),
            ("triangle 7: hit at t 0.25, u 0.5, v 0.125", "triangle 7: hit at t 1, u 0.5, v 0.125"),
            ("list ended: t 0.5 <= exit 0.75, accepted", "list ended: t 2 <= exit 3, accepted"),
            ("triangle 3: hit at t 1.5, not nearer than 0.25", "triangle 3: hit at t 6, not nearer than 1"),
            ("hit at t 0.5, before the ray's t_min 1", "hit at t 2, before the ray's t_min 4"),
            ("equation (1) at triangle 4: r 0.5 g 0.25 b 1.000", "equation (1) at triangle 4: r 0.5 g 0.25 b 1.000"),
            ("1 - u - v = -0.5, outside", "1 - u - v = -0.5, outside"),
        ] {
            assert_eq!(in_units(traced, &scale), scene);
            assert_eq!(in_units(traced, &Scale::new(Units::Traced, 4.0, [0.0; 3], 4.0)), traced);
        }
    }

    /// Numbers with a fraction are a t, a weight of the hit, a determinant, or a colour.
    #[test]
    fn every_fraction_in_a_history_is_known() {
        let scene = generate::cornell_box();
        let scale = Scale::new(Units::Scene, 4.0, [0.0; 3], 4.0);
        let mut fractions = 0;
        for (accelerator, numerics) in [
            (Accelerator::Grid, Numerics::Robust),
            (Accelerator::Grid, Numerics::Paper),
            (Accelerator::Bvh, Numerics::Robust),
        ] {
            let camera = scene.cameras[0].clone();
            let source = RaySource::Camera { camera, width: 16, height: 16 };
            let schedule = ScheduleKind::Second;
            let options = Options { accelerator, numerics, schedule, ..Options::new(source) };
            let (plan, data) = Plan::new(&scene, &options, &Limits::CPU).expect("a small scene");
            let run = RunSoFar { plan: &plan, data: &data, passes: &[], is_complete: false };
            for i in 0..256 {
                let life = run.follow::<f32>([i % 16, i / 16]).expect("a ray");
                for row in &life.rows {
                    let after = in_units(&row.why, &scale);
                    let pairs = row.why.split(' ').zip(after.split(' '));
                    let mut before = "";
                    for (word, converted) in pairs {
                        let is_fraction =
                            word.contains('.') && word.trim_end_matches([',', ';']).parse::<f32>().is_ok();
                        let is_plain = ["u", "v", "=", "r", "g", "b", "determinant", "below"].contains(&before);
                        fractions += u32::from(is_fraction);
                        assert!(!is_fraction || is_plain == (word == converted), "{before} {word}: {}", row.why);
                        before = word;
                    }
                }
            }
        }
        assert!(fractions > 1000, "{fractions}");
    }
}
