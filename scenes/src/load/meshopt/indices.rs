//! Modes 1 and 2: indices of triangle lists, which mostly share an edge with a triangle just before them, and sequences
//! of other indices.

use super::Problem;

const CUT: Problem = "the data ends too early";
const LEFT: Problem = "there is more data than elements";
const UNWRITTEN: Problem = "it refers to an index before the first";

/// Appends an index of 2 or 4 bytes.
fn put(index: u32, stride: usize, out: &mut Vec<u8>) {
    out.extend_from_slice(index.to_le_bytes().get(..stride).unwrap_or_default());
}

/// The last 16 entries pushed; 0 is the newest.
struct Recent<T> {
    entries: [T; 16],
    pushed: usize,
}

impl<T: Copy + Default> Recent<T> {
    fn new() -> Self {
        Self { entries: [T::default(); 16], pushed: 0 }
    }

    fn push(&mut self, entry: T) {
        self.entries[self.pushed % 16] = entry;
        self.pushed += 1;
    }

    fn get(&self, back: u8) -> Result<T, Problem> {
        let place = self.pushed.checked_sub(usize::from(back) + 1).ok_or(UNWRITTEN)?;
        self.entries.get(place % 16).copied().ok_or(UNWRITTEN)
    }
}

/// Bytes that are read one after the other.
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn byte(&mut self) -> Result<u8, Problem> {
        let (&byte, rest) = self.0.split_first().ok_or(CUT)?;
        self.0 = rest;
        Ok(byte)
    }

    /// An integer of seven bits per byte, the lowest first.
    fn varint(&mut self) -> Result<u32, Problem> {
        let mut value = 0_u32;
        for shift in [0, 7, 14, 21, 28] {
            let byte = self.byte()?;
            value |= u32::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Ok(value);
            }
        }
        Err("an integer has more than five bytes")
    }
}

/// The state of a triangle decoder.
struct Triangles<'a> {
    data: Bytes<'a>,
    /// The next index that has not been used yet.
    next: u32,
    /// The last index that was stored.
    last: u32,
    edges: Recent<(u32, u32)>,
    vertices: Recent<u32>,
}

/// Where an index of a triangle comes from.
enum Source {
    Next,
    Recent(u8),
    Stored,
}

impl Source {
    /// By four bits; 15 means what `Stored` says.
    fn new(bits: u8) -> Self {
        match bits {
            0 => Self::Next,
            15 => Self::Stored,
            _ => Self::Recent(bits - 1),
        }
    }
}

impl Triangles<'_> {
    fn next(&mut self) -> u32 {
        let next = self.next;
        self.next = next.wrapping_add(1);
        next
    }

    fn stored(&mut self) -> Result<u32, Problem> {
        let value = self.data.varint()?;
        self.last = self.last.wrapping_add((value >> 1) ^ (value & 1).wrapping_neg());
        Ok(self.last)
    }

    fn index(&mut self, source: &Source) -> Result<u32, Problem> {
        match source {
            Source::Next => Ok(self.next()),
            Source::Recent(back) => self.vertices.get(*back),
            Source::Stored => self.stored(),
        }
    }

    /// A triangle that shares an edge with a recent one.
    fn beside(&mut self, edge: u8, third: u8) -> Result<[u32; 3], Problem> {
        let (a, b) = self.edges.get(edge)?;
        let c = match third {
            0 => self.next(),
            13 | 14 => {
                self.last = if third == 13 { self.last.wrapping_sub(1) } else { self.last.wrapping_add(1) };
                self.last
            }
            15 => self.stored()?,
            back => self.vertices.get(back)?,
        };
        if matches!(third, 0 | 13..) {
            self.vertices.push(c);
        }
        self.edges.push((c, b));
        self.edges.push((a, c));
        Ok([a, b, c])
    }

    /// A triangle of three indices from these sources.
    fn apart(&mut self, sources: [Source; 3]) -> Result<[u32; 3], Problem> {
        let mut corners = [0; 3];
        for (corner, source) in corners.iter_mut().zip(&sources) {
            *corner = self.index(source)?;
        }
        let [a, b, c] = corners;
        for edge in [(b, a), (c, b), (a, c)] {
            self.edges.push(edge);
        }
        for (corner, source) in corners.into_iter().zip(&sources) {
            if !matches!(source, Source::Recent(_)) {
                self.vertices.push(corner);
            }
        }
        Ok(corners)
    }

    fn triangle(&mut self, code: u8, table: &[u8]) -> Result<[u32; 3], Problem> {
        let (high, low) = (code >> 4, code & 15);
        if high < 15 {
            return self.beside(high, low);
        }
        let (first, pair) = match low {
            14 | 15 => {
                let pair = self.data.byte()?;
                if pair == 0 {
                    self.next = 0;
                }
                (if low == 14 { Source::Next } else { Source::Stored }, pair)
            }
            _ => (Source::Next, table.get(usize::from(low)).copied().unwrap_or_default()),
        };
        self.apart([first, Source::new(pair >> 4), Source::new(pair & 15)])
    }
}

/// Appends `count` indices of triangles.
pub(super) fn triangles(input: &[u8], count: usize, stride: usize, out: &mut Vec<u8>) -> Result<(), Problem> {
    if !count.is_multiple_of(3) {
        return Err("the number of indices is no multiple of 3");
    }
    let [0xe1, rest @ ..] = input else { return Err("the data does not start with 0xe1") };
    let (codes, rest) = rest.split_at_checked(count / 3).ok_or(CUT)?;
    let (data, table) = rest.split_last_chunk::<16>().ok_or(CUT)?;
    if table.iter().any(|byte| byte >> 4 == 15 || byte & 15 == 15) || table[14..] != [0, 0] {
        return Err("its table has an entry that is not allowed");
    }
    let (edges, vertices) = (Recent::new(), Recent::new());
    let mut state = Triangles { data: Bytes(data), next: 0, last: 0, edges, vertices };
    for &code in codes {
        for index in state.triangle(code, table)? {
            put(index, stride, out);
        }
    }
    if state.data.0.is_empty() { Ok(()) } else { Err(LEFT) }
}

/// Appends `count` indices.
pub(super) fn sequence(input: &[u8], count: usize, stride: usize, out: &mut Vec<u8>) -> Result<(), Problem> {
    let [0xd1, rest @ ..] = input else { return Err("the data does not start with 0xd1") };
    let (data, _) = rest.split_last_chunk::<4>().ok_or(CUT)?;
    let mut data = Bytes(data);
    let mut last = [0_u32; 2];
    for _ in 0..count {
        let value = data.varint()?;
        let last = &mut last[(value & 1) as usize];
        *last = last.wrapping_add((value >> 2) ^ (value >> 1 & 1).wrapping_neg());
        put(*last, stride, out);
    }
    if data.0.is_empty() { Ok(()) } else { Err(LEFT) }
}
