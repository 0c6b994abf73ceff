//! OpenEXR: the image with each ray's hit, or streams.
//!
//! One part, scan lines, ZIP: what every viewer opens. Floats are 32 bits, ids are UINT, so nothing is rounded. The
//! channels of an image:
//!
//! | channel | type | holds | where nothing was hit |
//! |---|---|---|---|
//! | `R` `G` `B` | float | linear light | the background |
//! | `A` | float | 1 | 0 |
//! | `Z` | float | depth along the view, scene units | infinity |
//! | `Hit.T.V` | float | t of the hit, scene units per unit of the ray's direction | infinity |
//! | `Hit.Bary.U` `Hit.Bary.V` | float | weights of vertices 1 and 2 | 0 |
//! | `Hit.TriId.V` | uint | triangle id | 4294967295 |
//! | `Normal.X` `Normal.Y` `Normal.Z` | float | unit normal of the triangle's plane, by its winding | 0 |
//! | `Albedo.R` `.G` `.B` | float | colour of the surface: its material's, times that of vertices and texture | 0 |
//! | `Samples.V` | uint | samples of the pixel | the same |
//! | `Emitted.R` `.G` `.B` | float | light that the camera sees without a bounce: of surfaces that glow, and of the sky | the sky |
//! | `Direct.R` `.G` `.B` | float | light after one bounce | 0 |
//! | `Indirect.2.R` `.G` `.B`, … | float | light after two bounces, … | 0 |
//!
//! A camera ray's direction has length 1 along the view, so its t *is* the depth; input rays have no view, and `Z`
//! repeats t.

use std::io::{Seek, Write};

use ::exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image as ExrImage, Layer, LayerAttributes,
    LineOrder, WritableImage as _,
};

use crate::renderer::RayHit;
use crate::renderer::image::Image;
use crate::shared::constants::NO_TRIANGLE;
use crate::tables::stream::StreamData;

/// Why an EXR file was not written.
#[derive(Debug, thiserror::Error)]
pub enum ExrError {
    /// The output failed.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// The encoder refused the image.
    #[error("the EXR encoder refused the image: {0}")]
    Encode(String),
    /// A layer has another number of values than there are pixels.
    #[error("a layer has {values} values for {pixels} pixels")]
    WrongLength {
        /// Values.
        values: usize,
        /// Pixels.
        pixels: usize,
    },
    /// A hit names a triangle that the scene does not have.
    #[error("a hit names triangle {triangle}, the scene has {triangles}")]
    NoSuchTriangle {
        /// The id.
        triangle: u32,
        /// Number of triangles in the scene.
        triangles: usize,
    },
}

impl From<::exr::error::Error> for ExrError {
    fn from(error: ::exr::error::Error) -> Self {
        match error {
            ::exr::error::Error::Io(error) => Self::Io(error),
            other => Self::Encode(other.to_string()),
        }
    }
}

/// What a file has beside an image.
#[derive(Clone, Copy, Debug)]
pub struct Layers<'a> {
    /// Each pixel's hit.
    pub hits: &'a [Option<RayHit>],
    /// The scene's corners, for the normals.
    pub triangles: &'a [[[f32; 3]; 3]],
    /// Each pixel's [albedo](crate::renderer::Renderer::albedo).
    pub albedo: &'a [[f32; 3]],
    /// Samples of each pixel.
    pub samples: u32,
    /// The images of the same paths with at most 0, 1, 2… bounces, if the light of each number of bounces is wanted: the
    /// difference of two images. The last one is the image itself and not among them.
    pub bounces: &'a [Image],
}

/// Writes the image and its layers.
///
/// # Errors
/// If `out` fails, or the sizes do not match.
pub fn write_image(out: &mut (impl Write + Seek), image: &Image, layers: &Layers<'_>) -> Result<(), ExrError> {
    let Layers { hits, triangles, albedo, samples, bounces } = *layers;
    let pixels = image.pixels.len();
    let lengths = [hits.len(), albedo.len()].into_iter().chain(bounces.iter().map(|of| of.pixels.len()));
    if let Some(values) = lengths.into_iter().find(|&length| length != pixels) {
        return Err(ExrError::WrongLength { values, pixels });
    }
    let normals = hits
        .iter()
        .map(|hit| match hit {
            None => Ok([0.0; 3]),
            Some(hit) => triangles
                .get(hit.triangle as usize)
                .map(plane_normal)
                .ok_or(ExrError::NoSuchTriangle { triangle: hit.triangle, triangles: triangles.len() }),
        })
        .collect::<Result<Vec<_>, _>>()?;
    let floats = |f: &dyn Fn(&RayHit) -> f32, miss: f32| {
        FlatSamples::F32(hits.iter().map(|hit| hit.as_ref().map_or(miss, f)).collect())
    };
    let color = |c: usize| FlatSamples::F32(image.pixels.iter().map(|p| p[c]).collect());
    let normal = |a: usize| FlatSamples::F32(normals.iter().map(|n| n[a]).collect());
    let ids = hits.iter().map(|hit| hit.as_ref().map_or(NO_TRIANGLE, |h| h.triangle)).collect();
    let t = || floats(&|hit| hit.t as f32, f32::INFINITY);
    let mut channels = vec![
        AnyChannel::new("R", color(0)),
        AnyChannel::new("G", color(1)),
        AnyChannel::new("B", color(2)),
        AnyChannel::new("A", color(3)),
        AnyChannel::new("Z", t()),
        AnyChannel::new("Hit.T.V", t()),
        AnyChannel::new("Hit.Bary.U", floats(&|hit| hit.u, 0.0)),
        AnyChannel::new("Hit.Bary.V", floats(&|hit| hit.v, 0.0)),
        AnyChannel::new("Hit.TriId.V", FlatSamples::U32(ids)),
        AnyChannel::new("Normal.X", normal(0)),
        AnyChannel::new("Normal.Y", normal(1)),
        AnyChannel::new("Normal.Z", normal(2)),
        AnyChannel::new("Samples.V", FlatSamples::U32(vec![samples; pixels])),
    ];
    let mut add = |layer: &str, value: &dyn Fn(usize, usize) -> f32| {
        channels.extend(["R", "G", "B"].into_iter().enumerate().map(|(c, name)| {
            let values = (0..pixels).map(|i| value(i, c)).collect();
            AnyChannel::new(format!("{layer}.{name}").as_str(), FlatSamples::F32(values))
        }));
    };
    add("Albedo", &|i, c| albedo[i][c]);
    let mut before: Option<&Image> = None;
    for (bounce, light) in bounces.iter().chain((!bounces.is_empty()).then_some(image)).enumerate() {
        let layer = match bounce {
            0 => "Emitted".to_owned(),
            1 => "Direct".to_owned(),
            more => format!("Indirect.{more}"),
        };
        add(&layer, &|i, c| light.pixels[i][c] - before.map_or(0.0, |before| before.pixels[i][c]));
        before = Some(light);
    }
    write_channels(out, image.width, image.height, channels)
}

/// Writes an image without hits.
///
/// # Errors
/// If `out` fails.
pub fn write_colors(out: &mut (impl Write + Seek), image: &Image) -> Result<(), ExrError> {
    let channels = ["R", "G", "B", "A"].into_iter().enumerate();
    let channel =
        |(c, name)| AnyChannel::new(name, FlatSamples::F32(image.pixels.iter().map(|p: &[f32; 4]| p[c]).collect()));
    write_channels(out, image.width, image.height, channels.map(channel).collect())
}

/// Writes a stream: the channel `hit.u` is layer `u` of stream `hit`. A float layer, including floats stored as bits in
/// an integer texel, becomes a FLOAT channel, the others UINT; either way the bits are kept. Layers r, g and b are also
/// the channels R, G and B, which viewers show as a picture.
///
/// # Errors
/// If `out` fails.
pub fn write_stream(out: &mut (impl Write + Seek), data: &StreamData) -> Result<(), ExrError> {
    let info = data.stream.info();
    let samples = |layer: usize| {
        if data.stream.is_float_layer(layer) {
            FlatSamples::F32(data.layer(layer).iter().map(|&bits| f32::from_bits(bits)).collect())
        } else {
            FlatSamples::U32(data.layer(layer).to_vec())
        }
    };
    let channel =
        |(layer, name): (usize, &&str)| AnyChannel::new(format!("{}.{name}", info.name).as_str(), samples(layer));
    let mut channels: Vec<_> = info.layers.iter().enumerate().map(channel).collect();
    if let [r, g, b, ..] = info.layers
        && [*r, *g, *b] == ["r", "g", "b"]
    {
        channels.extend(["R", "G", "B"].into_iter().enumerate().map(|(c, name)| AnyChannel::new(name, samples(c))));
    }
    write_channels(out, data.width, data.height, channels)
}

fn write_channels(
    out: &mut (impl Write + Seek),
    width: u32,
    height: u32,
    channels: Vec<AnyChannel<FlatSamples>>,
) -> Result<(), ExrError> {
    let attributes = LayerAttributes { software_name: Some("raystep".into()), ..LayerAttributes::default() };
    let encoding =
        Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
    let size = (width as usize, height as usize);
    let layer = Layer::new(size, attributes, encoding, AnyChannels::sort(channels.into()));
    ExrImage::from_layer(layer).write().non_parallel().to_buffered(out)?;
    Ok(())
}

/// The unit normal by the corners' winding; 0 for a triangle with no area.
fn plane_normal(corners: &[[f32; 3]; 3]) -> [f32; 3] {
    let [a, b, c] = corners.map(|p| glam::Vec3::from(p).as_dvec3());
    (b - a).cross(c - a).normalize_or_zero().as_vec3().to_array()
}

#[cfg(test)]
mod tests {
    use crate::programs::closest_hit::streams;
    use std::io::Cursor;

    use ::exr::prelude::{ReadChannels as _, ReadLayers as _};

    use super::*;

    fn read(file: Vec<u8>) -> Vec<(String, FlatSamples)> {
        let image = ::exr::prelude::read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .first_valid_layer()
            .all_attributes()
            .from_buffered(Cursor::new(file))
            .expect("a valid EXR");
        image.layer_data.channel_data.list.into_iter().map(|c| (c.name.to_string(), c.sample_data)).collect()
    }

    #[test]
    fn an_image_comes_back_with_every_channel() {
        let image = Image { width: 2, height: 1, pixels: vec![[0.1, 0.2, 0.3, 1.0], [0.4, 0.5, 0.6, 0.0]] };
        let hits = [Some(RayHit { t: 2.5, u: 0.25, v: 0.5, triangle: 1 }), None];
        let triangles = [[[0.0; 3]; 3], [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 2.0, 0.0]]];
        let mut file = Cursor::new(Vec::new());
        let least = Image { pixels: vec![[0.0, 0.125, 0.25, 1.0], [0.5; 4]], ..image.clone() };
        let albedo = [[0.5, 0.25, 0.125], [0.0; 3]];
        let layers = Layers { hits: &hits, triangles: &triangles, albedo: &albedo, samples: 7, bounces: &[least] };
        write_image(&mut file, &image, &layers).expect("memory");
        let expected = [
            ("A", FlatSamples::F32(vec![1.0, 0.0])),
            ("Albedo.B", FlatSamples::F32(vec![0.125, 0.0])),
            ("Albedo.G", FlatSamples::F32(vec![0.25, 0.0])),
            ("Albedo.R", FlatSamples::F32(vec![0.5, 0.0])),
            ("B", FlatSamples::F32(vec![0.3, 0.6])),
            ("Direct.B", FlatSamples::F32(vec![0.3 - 0.25, 0.6 - 0.5])),
            ("Direct.G", FlatSamples::F32(vec![0.2 - 0.125, 0.0])),
            ("Direct.R", FlatSamples::F32(vec![0.1, 0.4 - 0.5])),
            ("Emitted.B", FlatSamples::F32(vec![0.25, 0.5])),
            ("Emitted.G", FlatSamples::F32(vec![0.125, 0.5])),
            ("Emitted.R", FlatSamples::F32(vec![0.0, 0.5])),
            ("G", FlatSamples::F32(vec![0.2, 0.5])),
            ("Hit.Bary.U", FlatSamples::F32(vec![0.25, 0.0])),
            ("Hit.Bary.V", FlatSamples::F32(vec![0.5, 0.0])),
            ("Hit.T.V", FlatSamples::F32(vec![2.5, f32::INFINITY])),
            ("Hit.TriId.V", FlatSamples::U32(vec![1, NO_TRIANGLE])),
            ("Normal.X", FlatSamples::F32(vec![0.0, 0.0])),
            ("Normal.Y", FlatSamples::F32(vec![0.0, 0.0])),
            ("Normal.Z", FlatSamples::F32(vec![1.0, 0.0])),
            ("R", FlatSamples::F32(vec![0.1, 0.4])),
            ("Samples.V", FlatSamples::U32(vec![7, 7])),
            ("Z", FlatSamples::F32(vec![2.5, f32::INFINITY])),
        ];
        let channels = read(file.into_inner());
        assert_eq!(channels.len(), expected.len());
        for ((name, samples), (expected_name, expected)) in channels.into_iter().zip(expected) {
            assert_eq!((name.as_str(), samples), (expected_name, expected));
        }
    }

    #[test]
    fn parts_that_do_not_fit_are_refused() {
        let image = Image { width: 1, height: 1, pixels: vec![[0.0; 4]] };
        let hit = Some(RayHit { t: 1.0, u: 0.0, v: 0.0, triangle: 7 });
        let mut out = Cursor::new(Vec::new());
        let layers = Layers { hits: &[hit], triangles: &[], albedo: &[[0.0; 3]], samples: 1, bounces: &[] };
        let short = [Layers { hits: &[], ..layers }, Layers { albedo: &[], ..layers }];
        for layers in short {
            let refused = write_image(&mut out, &image, &layers);
            assert!(matches!(refused, Err(ExrError::WrongLength { values: 0, pixels: 1 })));
        }
        let refused = write_image(&mut out, &image, &layers);
        assert!(matches!(refused, Err(ExrError::NoSuchTriangle { triangle: 7, triangles: 0 })));
    }

    #[test]
    fn a_stream_keeps_its_bits_and_types() {
        let bits = vec![1.5f32.to_bits(), 2.5f32.to_bits(), 0, 1.0f32.to_bits(), 0xffff_ffff, 0x0100_0001];
        let data = StreamData { stream: streams::HIT, width: 2, height: 1, bits };
        let mut file = Cursor::new(Vec::new());
        write_stream(&mut file, &data).expect("memory");
        let channels = read(file.into_inner());
        assert_eq!(channels[0], ("hit.triangle".to_owned(), FlatSamples::U32(vec![0xffff_ffff, 0x0100_0001])));
        assert_eq!(channels[1], ("hit.u".to_owned(), FlatSamples::F32(vec![1.5, 2.5])));
        assert_eq!(channels[2], ("hit.v".to_owned(), FlatSamples::F32(vec![0.0, 1.0])));
    }
}
