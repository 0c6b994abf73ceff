//! Operations and bytes of a kernel.

/// What elements took: operations as the source states them, and bytes moved to and from memory.
///
/// - An operation is one operator, conversion or built-in function on one component: a sum of two `vec3f` is three.
///   `fma` and `clamp` are two. What a driver's compiler would merge or move out of a loop is counted each time.
/// - Literals, `let`, local variables, constructors, swizzles and bit casts are free, and so are jumps and the
///   arithmetic of an index into an array.
/// - A component of a stream is four bytes, each time that it is loaded or stored. So is a word of a buffer or uniform;
///   what a cache would save is counted.
/// - As everywhere in this module, finding the element and telling others about it are left out: lists of live rays, and
///   the numbers of rays sent to each state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Arithmetic on floats: `+ - * / %`, negation, and functions such as `sqrt`, `min` and `floor`.
    pub float_operations: u64,
    /// The same on integers; operations on bits; conversions between floats and integers.
    pub integer_operations: u64,
    /// Comparisons of any type, `select`, and logical operators without a jump: `!`, `any`, `all`.
    pub comparisons: u64,
    /// Bytes loaded from streams.
    pub stream_bytes_read: u64,
    /// Bytes stored to streams.
    pub stream_bytes_written: u64,
    /// Bytes loaded from buffers of the scene.
    pub buffer_bytes_read: u64,
    /// Bytes loaded from uniforms, which a device keeps close by.
    pub uniform_bytes_read: u64,
}

impl Work {
    /// All operations.
    #[must_use]
    pub fn operations(&self) -> u64 {
        self.float_operations + self.integer_operations + self.comparisons
    }

    /// All bytes but those of uniforms.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.stream_bytes_read + self.stream_bytes_written + self.buffer_bytes_read
    }

    /// Each number, in the order of the fields.
    #[must_use]
    pub fn each(&self) -> [u64; 7] {
        [
            self.float_operations,
            self.integer_operations,
            self.comparisons,
            self.stream_bytes_read,
            self.stream_bytes_written,
            self.buffer_bytes_read,
            self.uniform_bytes_read,
        ]
    }

    /// Adds work that was done a number of times.
    pub fn add(&mut self, other: &Self, times: u64) {
        self.float_operations += times * other.float_operations;
        self.integer_operations += times * other.integer_operations;
        self.comparisons += times * other.comparisons;
        self.stream_bytes_read += times * other.stream_bytes_read;
        self.stream_bytes_written += times * other.stream_bytes_written;
        self.buffer_bytes_read += times * other.buffer_bytes_read;
        self.uniform_bytes_read += times * other.uniform_bytes_read;
    }
}
