//! Parses links. The text is untrusted: it may be wrong in any way, and nothing panics.

use std::str::FromStr;

use percent_encoding::percent_decode_str;
use raystep_kernels::options::Choices;
use raystep_kernels::{Stream, programs};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::error::start;
use super::{Link, LinkCamera, LinkDevice, LinkError, LinkRay, LinkStream, MOST_PIXELS, VERSION, keys, linked};
use crate::ray_text::RayTextError;

/// The pairs of a link, each key once.
struct Pairs(Vec<(&'static str, String)>);

impl FromStr for Link {
    type Err = LinkError;

    fn from_str(text: &str) -> Result<Self, LinkError> {
        let text = text.trim();
        let rest = text.strip_prefix("raystep:").ok_or_else(|| LinkError::NotALink(start(text)))?;
        let (version, query) = rest.split_once('?').unwrap_or((rest, ""));
        if version.parse() != Ok(VERSION) {
            return Err(LinkError::Version(start(version)));
        }
        let pairs = Pairs::read(query)?;
        let default = Self::default();
        let choices = choices(&pairs, default.choices)?;
        let link = Self {
            scene: pairs.take("scene", |v| not_empty(v).ok_or("expected a file".into()))?,
            scene_index: pairs.take("scene-index", count)?,
            scene_hash: pairs.take("scene-hash", named)?,
            camera: camera(&pairs)?,
            size: pairs.take("size", size)?.unwrap_or(default.size),
            choices,
            device: pairs.take("device", device)?.unwrap_or(default.device),
            adapter: pairs.take("adapter", |v| not_empty(v).ok_or("expected part of an adapter's name".into()))?,
            ray: ray(&pairs)?,
            pass: pairs.take("pass", count)?,
            stream: pairs.take("stream", |value| stream(value, &choices))?,
            zoom: pairs.take("zoom", |v| {
                let points = finite::<f32, 1>(v).map(|[points]| points).filter(|&points| points > 0.0);
                points.ok_or("expected a number above 0".into())
            })?,
            pan: pairs.take("pan", |v| finite(v).ok_or("expected two numbers, such as 12.5,30".into()))?,
        };
        if let Some(LinkRay::Pixel([x, y])) = link.ray
            && (x >= link.size[0] || y >= link.size[1])
        {
            let (right, bottom) = (link.size[0] - 1, link.size[1] - 1);
            let wanted = format!("the image has pixels 0,0 to {right},{bottom}; size enlarges it");
            return Err(LinkError::Value { key: "pixel", value: format!("{x},{y}"), wanted });
        }
        Ok(link)
    }
}

/// As text, which can be copied from a file.
impl Serialize for Link {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for Link {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        String::deserialize(from)?.parse().map_err(D::Error::custom)
    }
}

impl Pairs {
    fn read(query: &str) -> Result<Self, LinkError> {
        let mut pairs: Vec<(&'static str, String)> = Vec::new();
        for part in query.split('&').filter(|_| !query.is_empty()) {
            let (key, value) = part.split_once('=').ok_or_else(|| LinkError::NoValue(start(part)))?;
            let known = keys().find(|&known| known == key);
            let key = known.ok_or_else(|| LinkError::UnknownKey(start(key)))?;
            if pairs.iter().any(|(other, _)| *other == key) {
                return Err(LinkError::Twice(key));
            }
            let decoded = percent_decode_str(value).decode_utf8().map_err(|_| LinkError::Value {
                key,
                value: start(value),
                wanted: "not UTF-8 after percent-decoding".into(),
            })?;
            pairs.push((key, decoded.into_owned()));
        }
        Ok(Self(pairs))
    }

    fn has(&self, key: &str) -> bool {
        self.0.iter().any(|(k, _)| *k == key)
    }

    /// The value of a key, parsed by `parse`, which describes the valid values.
    fn take<T>(
        &self,
        key: &'static str,
        parse: impl FnOnce(&str) -> Result<T, String>,
    ) -> Result<Option<T>, LinkError> {
        let Some((_, value)) = self.0.iter().find(|(k, _)| *k == key) else { return Ok(None) };
        parse(value).map(Some).map_err(|wanted| LinkError::Value { key, value: start(value), wanted })
    }
}

fn choices(pairs: &Pairs, mut choices: Choices) -> Result<Choices, LinkError> {
    for row in linked() {
        pairs.take(row.name, |value| row.set(&mut choices, value))?;
    }
    match choices.mapping.fragment().and_then(|how| how.fault()) {
        None => Ok(choices),
        Some(fault) => {
            Err(LinkError::Value { key: "mapping", value: "fragment".into(), wanted: fault.replace("--", "") })
        }
    }
}

fn camera(pairs: &Pairs) -> Result<LinkCamera, LinkError> {
    const POINT: &str = "expected three numbers, such as 0,1.5,-3";
    let point = |key| pairs.take(key, |v| finite::<f64, 3>(v).ok_or(POINT.into()));
    let index = pairs.take("camera", count)?;
    let (eye, look_at, up) = (point("eye")?, point("look-at")?, point("up")?);
    let fov_deg = pairs.take("fov", |v| {
        let angle = finite::<f64, 1>(v).map(|[degrees]| degrees).filter(|&degrees| degrees > 0.0 && degrees < 180.0);
        angle.ok_or("expected an angle between 0 and 180 degrees".into())
    })?;
    if index.is_some()
        && let Some(other) = ["eye", "look-at", "up", "fov"].into_iter().find(|key| pairs.has(key))
    {
        return Err(LinkError::Both("camera", other));
    }
    match (eye, look_at) {
        (Some(eye), Some(look_at)) => Ok(LinkCamera::Placed {
            eye,
            look_at,
            up: up.unwrap_or(LinkCamera::UP),
            fov_deg: fov_deg.unwrap_or(LinkCamera::FOV_DEG),
        }),
        (Some(_), None) => Err(LinkError::Without("eye", "look-at")),
        (None, _) => match ["look-at", "up", "fov"].into_iter().find(|key| pairs.has(key)) {
            Some(key) => Err(LinkError::Without(key, "eye")),
            None => Ok(index.map_or(LinkCamera::Default, LinkCamera::Index)),
        },
    }
}

fn ray(pairs: &Pairs) -> Result<Option<LinkRay>, LinkError> {
    const PIXEL: &str = "expected two integers, such as 256,256";
    let pixel = pairs.take("pixel", |v| numbers(v, |part| part.parse::<u32>().ok()).ok_or(PIXEL.into()))?;
    let given = pairs.take("ray", |v| v.parse().map_err(|error: RayTextError| error.to_string()))?;
    match (pixel, given) {
        (Some(_), Some(_)) => Err(LinkError::Both("pixel", "ray")),
        (pixel, given) => Ok(pixel.map(LinkRay::Pixel).or(given.map(LinkRay::Given))),
    }
}

fn size(value: &str) -> Result<[u32; 2], String> {
    let sides = value.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    let fits = |sides: &[u32; 2]| sides.iter().all(|side| (1..=MOST_PIXELS).contains(side));
    sides.filter(fits).ok_or_else(|| format!("expected two numbers from 1 to {MOST_PIXELS}, such as 640x480"))
}

fn stream(value: &str, choices: &Choices) -> Result<LinkStream, String> {
    let (name, layer) = match value.split_once('.') {
        Some((name, layer)) => (name, Some(layer)),
        None => (value, None),
    };
    let program = programs::chosen(choices).program();
    let names = || program.streams().map(Stream::name).collect::<Vec<_>>().join(", ");
    let stream = program.stream(name).ok_or_else(|| format!("expected one of {}", names()))?;
    let layers = stream.info().layers;
    let index = layer.map(|layer| layers.iter().position(|l| *l == layer));
    match index {
        Some(None) => Err(format!("layers of {name} are {}", layers.join(", "))),
        _ => Ok(LinkStream { stream, layer: index.flatten() }),
    }
}

fn device(value: &str) -> Result<LinkDevice, String> {
    let device = LinkDevice::ALL.into_iter().find(|d| d.name() == value);
    device.ok_or_else(|| format!("expected one of {}", LinkDevice::ALL.map(LinkDevice::name).join(", ")))
}

fn named<T: FromStr<Err: ToString>>(value: &str) -> Result<T, String> {
    value.parse().map_err(|e: T::Err| e.to_string())
}

fn count(value: &str) -> Result<usize, String> {
    value.parse().map_err(|_| "expected an integer of at least 0".into())
}

fn not_empty(value: &str) -> Option<String> {
    (!value.is_empty()).then(|| value.to_owned())
}

/// The expected count of numbers, separated by commas.
fn numbers<T, const N: usize>(value: &str, parse: impl Fn(&str) -> Option<T>) -> Option<[T; N]> {
    let numbers = value.split(',').take(N + 1).map(parse).collect::<Option<Vec<_>>>()?;
    numbers.try_into().ok()
}

/// The same, all finite.
fn finite<T: FromStr + Copy + Into<f64>, const N: usize>(value: &str) -> Option<[T; N]> {
    numbers(value, |part| part.parse::<T>().ok().filter(|&n| n.into().is_finite()))
}
