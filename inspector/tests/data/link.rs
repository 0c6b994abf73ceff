//! Links survive a round trip, and no text makes parsing panic.

use raystep_inspector::link::{self, Link, LinkCamera, LinkDevice, LinkRay, LinkStream};
use raystep_inspector::ray_text::GivenRay;
use raystep_inspector::settings::Settings;
use raystep_kernels::options::MOST_CELLS;
use raystep_kernels::options::rows::{ROWS, Refusal, Row, Values};
use raystep_kernels::programs::closest_hit::streams;
use raystep_kernels::{Accelerator, Choices, GridSize, ScheduleKind, programs};
use raystep_lab::Hash;

struct Random(fastrand::Rng);

impl Random {
    fn new(seed: u64) -> Self {
        Self(fastrand::Rng::with_seed(seed))
    }

    fn bits(&mut self) -> u64 {
        self.0.u64(..)
    }

    fn below(&mut self, n: usize) -> usize {
        self.0.usize(..n)
    }

    fn of<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.below(all.len())]
    }

    fn maybe<T>(&mut self, make: impl FnOnce(&mut Self) -> T) -> Option<T> {
        (self.below(2) == 0).then(|| make(self))
    }

    /// Any finite number, with any exponent.
    fn f64(&mut self) -> f64 {
        let value = f64::from_bits(self.bits());
        if value.is_finite() { value } else { -0.0 }
    }

    fn f32(&mut self) -> f32 {
        let value = f32::from_bits(self.bits() as u32);
        if value.is_finite() { value } else { -0.0 }
    }

    fn text(&mut self) -> String {
        let signs = ['a', '/', '.', ' ', '&', '=', '?', '%', '"', '$', '`', '\\', '!', '\n', 'ø', '深', '🜁', '\0'];
        (0..=self.below(12)).map(|_| self.of(&signs)).collect()
    }

    fn link(&mut self) -> Link {
        let size = [1 + self.below(32_768) as u32, 1 + self.below(32_768) as u32];
        let index = self.maybe(|r| r.below(usize::MAX));
        let camera = match self.below(3) {
            0 => LinkCamera::Default,
            1 => LinkCamera::Index(self.below(9)),
            _ => LinkCamera::Placed {
                eye: [0; 3].map(|_| self.f64()),
                look_at: [0; 3].map(|_| self.f64()),
                up: if self.below(2) == 0 { LinkCamera::UP } else { [0; 3].map(|_| self.f64()) },
                fov_deg: self.of(&[40.0, 0.1, 1e-300, 179.999_999_999_9]),
            },
        };
        let choices = self.choices();
        let program = choices.program;
        Link {
            scene: self.maybe(Self::text),
            scene_index: index,
            scene_hash: self.maybe(|r| Hash::of(&r.bits().to_le_bytes())),
            camera,
            size,
            device: self.of(&LinkDevice::ALL),
            adapter: self.maybe(Self::text),
            ray: match self.below(3) {
                0 => None,
                1 => Some(LinkRay::Pixel(size.map(|side| self.below(side as usize) as u32))),
                _ => Some(LinkRay::Given(GivenRay([0; 6].map(|_| self.f32().into())))),
            },
            pass: self.maybe(|r| r.below(usize::MAX)),
            stream: self.maybe(|r| {
                let stream = r.of(&programs::named(program).streams().collect::<Vec<_>>());
                LinkStream { stream, layer: r.maybe(|r| r.below(stream.layers())) }
            }),
            zoom: self.maybe(|r| r.f32().abs().max(f32::MIN_POSITIVE)),
            pan: self.maybe(|r| [r.f32(), r.f32()]),
            choices,
        }
    }

    /// Values of all options that links have, as far as they go together.
    fn choices(&mut self) -> Choices {
        let mut choices = Choices::stepped();
        for row in ROWS.iter().filter(|row| row.is_linked) {
            let value = match row.values {
                Values::Names(names) => self.of(&names()).to_owned(),
                Values::Whole(least, most) => (least + self.below((most - least) as usize + 1) as u32).to_string(),
                Values::Switch => (self.below(2) == 0).to_string(),
                Values::Cells => [0; 3].map(|_| (1 + self.below(MOST_CELLS as usize)).to_string()).join(","),
            };
            let mut chosen = choices;
            let is_possible = (row.applies)(&choices) && row.set(&mut chosen, &value).is_ok();
            let is_refused = |row: &Row| matches!((row.refused)(&chosen), Some(Refusal::Impossible(_)));
            if is_possible && !ROWS.iter().any(is_refused) {
                choices = chosen;
            }
        }
        choices
    }
}

/// Every number by its bits, so that -0 differs from 0.
fn exactly(link: &Link) -> String {
    format!("{link:?}")
}

#[test]
fn every_link_comes_back_bit_for_bit_and_is_safe_in_a_shell() {
    let mut random = Random::new(1);
    for _ in 0..20_000 {
        let link = random.link();
        let text = link.to_string();
        assert!(text.bytes().all(|b| b.is_ascii_graphic() && !b"\"$`\\!'<>|;*".contains(&b)), "{text}");
        let back: Link = text.parse().unwrap_or_else(|e| panic!("{text}: {e}"));
        assert_eq!(exactly(&back), exactly(&link), "{text}");
    }
}

#[test]
fn a_link_reads_as_the_options_do() {
    let link = Link {
        scene: Some("scenes/cornell-box.gltf".into()),
        ray: Some(LinkRay::Pixel([270, 256])),
        pass: Some(41),
        stream: Some(LinkStream { stream: streams::TMAX, layer: Some(0) }),
        choices: Choices { accelerator: Accelerator::Bvh, ..Choices::stepped() },
        ..Link::default()
    };
    let text = "raystep:1?scene=scenes/cornell-box.gltf&accelerator=bvh&pixel=270,256&pass=41&stream=tmax.x";
    assert_eq!(link.to_string(), text);
    let other =
        "raystep:1?stream=tmax.x&pass=41&size=512x512&pixel=270,256&accelerator=bvh&scene=scenes%2Fcornell-box.gltf";
    assert_eq!(other.parse(), Ok(link));
    assert_eq!("raystep:1".parse(), Ok(Link::default()));
    assert_eq!("raystep:1?".parse(), Ok(Link::default()));
    let ray = "raystep:1?ray=-0.5,0x3e800000,5,0,0,-1".parse::<Link>().map(|l| l.to_string());
    assert_eq!(ray.as_deref(), Ok("raystep:1?ray=-0.5,0.25,5,0,0,-1"));
    assert_eq!("raystep:1?grid=8".parse::<Link>().map(|l| l.choices.grid), Ok(GridSize::Cells([8; 3])));
}

/// Defaults of version 1 never change: other defaults require a new version.
#[test]
fn the_defaults_of_version_1_stay() {
    let all = "raystep:1?size=512x512&program=closest-hit&elements=4096&integrator=local&accelerator=grid&mapping=compute&scene-data=\
               buffers&schedule=compact&numerics=robust&order=rounded&grid=auto&skip=auto&steps-per-pass=1&keep-all=false&spp=1\
               &sampler=sobol&seed=0&device=auto";
    assert_eq!(all.parse(), Ok(Link::default()));
    for row in ROWS.iter().filter(|row| row.is_linked && (row.applies)(&Choices::stepped())) {
        assert!(all.contains(&format!("&{}=", row.name)), "{}", row.name);
    }
    let placed = |more: &str| format!("raystep:1?eye=1,2,3&look-at=0,0,0{more}").parse::<Link>();
    assert_eq!(placed(""), placed("&up=0,1,0&fov=40"));
}

#[test]
fn a_wrong_link_says_in_one_line_what_would_be_right() {
    let cases = [
        ("", "raystep:1?"),
        ("https://example.org/?scene=a", "raystep:1?"),
        ("raystep:2?scene=a", "version \"2\", but this raystep reads version 1"),
        ("raystep:?scene=a", "version"),
        ("raystep:1?scene", "expected KEY=VALUE"),
        ("raystep:1?scene=a&", "expected KEY=VALUE"),
        ("raystep:1?scene=a&colour=red", "\"colour\" is not a key of a link; the keys are scene, "),
        ("raystep:1?Scene=a", "not a key"),
        ("raystep:1?scene=", "expected a file"),
        ("raystep:1?scene=%ff", "not UTF-8"),
        ("raystep:1?pass=1&pass=1", "pass is there twice"),
        ("raystep:1?pass=-1", "pass=\"-1\": expected an integer of at least 0"),
        ("raystep:1?pass=99999999999999999999999", "an integer"),
        ("raystep:1?size=0x8", "1 to 32768"),
        ("raystep:1?size=512", "640x480"),
        ("raystep:1?accelerator=kd", "auto, grid, irregular, bvh, none"),
        ("raystep:1?schedule=", "first, second, compact, fused"),
        ("raystep:1?numerics=exact", "robust, paper"),
        ("raystep:1?skip=yes", "auto, on, off"),
        ("raystep:1?device=tpu", "auto, gpu, cpu"),
        ("raystep:1?keep-all=1", "true or false"),
        ("raystep:1?grid=1,2", "32,8,32"),
        ("raystep:1?grid=4097", "1 to 4096"),
        ("raystep:1?steps-per-pass=0", "1 to 4096"),
        ("raystep:1?camera=0&fov=30", "camera and fov exclude each other"),
        ("raystep:1?eye=0,0,0", "eye requires look-at"),
        ("raystep:1?look-at=0,0,0", "look-at requires eye"),
        ("raystep:1?fov=30", "fov requires eye"),
        ("raystep:1?eye=0,0,inf&look-at=0,0,0", "three numbers"),
        ("raystep:1?eye=0,0,1e999&look-at=0,0,0", "three numbers"),
        ("raystep:1?eye=0,0,1&look-at=0,0,0&fov=180", "between 0 and 180"),
        ("raystep:1?pixel=512,0", "0,0 to 511,511"),
        ("raystep:1?pixel=1", "256,256"),
        ("raystep:1?pixel=1,2&ray=0,0,0,0,0,1", "pixel and ray exclude each other"),
        ("raystep:1?ray=0,0,0,0,0,0x7f800000", "a direction other than 0"),
        ("raystep:1?ray=0,0,0,0,0,1,0", "six numbers"),
        ("raystep:1?stream=depth", "ray_origin, ray_direction, ray_interval, state"),
        ("raystep:1?stream=tmax.w", "layers of tmax are x, y, z"),
        ("raystep:1?zoom=0", "above 0"),
        ("raystep:1?pan=1", "two numbers"),
    ];
    for (text, wanted) in cases {
        let error = text.parse::<Link>().expect_err(text).to_string();
        assert!(error.contains(wanted) && !error.contains('\n') && error.len() < 500, "{text}: {error}");
    }
}

#[test]
fn no_text_panics() {
    let mut random = Random::new(2);
    let keys: Vec<&str> = link::keys().collect();
    let values = ["", "x", ",", ",,", "0x", "NaN", "1e999", "-", "%", "%f", "tmax.", ".x", "0,0,0", "深,深", "1x1"];
    for _ in 0..20_000 {
        // A link with a piece removed, inserted or doubled, or pairs of a key and arbitrary text.
        let mut text: Vec<char> = random.link().to_string().chars().collect();
        for _ in 0..=random.below(4) {
            let at = random.below(text.len().max(1));
            match random.below(3) {
                0 => text.truncate(at),
                1 => text.extend(random.text().chars()),
                _ => text.insert(at.min(text.len()), random.of(&['=', '&', '%', '0', ',', '深', '.'])),
            }
        }
        let _ = text.into_iter().collect::<String>().parse::<Link>();
        let key = random.of(&keys);
        for value in values {
            let _ = format!("raystep:1?{key}={value}{}", random.text()).parse::<Link>();
        }
    }
    let long = "raystep:1?".to_owned() + &"深".repeat(100_000);
    assert!(long.parse::<Link>().expect_err("no pair").to_string().len() < 400);
}

/// Steps are of the compact schedule alone: a link of another must not have them, or a command would refuse it.
#[test]
fn steps_are_left_out_where_they_mean_nothing() {
    let choices = Choices { schedule: ScheduleKind::Second, steps_per_pass: 8, ..Choices::stepped() };
    let link = Settings { choices, ..Settings::default() }.link();
    assert_eq!(link.to_string(), "raystep:1?schedule=second&device=gpu");
}
