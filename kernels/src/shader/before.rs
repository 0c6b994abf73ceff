//! Streams of which a pass reads other elements than it writes: it reads them as they were before the pass.
//!
//! All threads run at once, so what one stores another would read or not, as the device happens to run them. Such a stream
//! has a copy from before the pass, and loads are from the copy. A kernel that loads and stores a texel of its own alone
//! needs none.

use std::collections::{BTreeMap, HashMap, HashSet};

use naga::valid::{Capabilities, FunctionInfo, GlobalUse, ModuleInfo, ValidationFlags, Validator};
use naga::{
    AddressSpace, Block, Expression, Function, GlobalVariable, Handle, Module, Statement, StorageAccess, TypeInner,
};

use super::{Resource, Variant};
use crate::compose::{Word, WordKind, words};
use crate::tables::stream::{Stream, Texel};

/// What the copy of a stream is called.
#[must_use]
pub fn name_of_copy(stream: &str) -> String {
    format!("{stream}_before")
}

impl Variant {
    /// The streams that the kernel writes, and of which it may load other texels than those that the same thread stores.
    #[must_use]
    pub(crate) fn loads_of_others(&self) -> Vec<Stream> {
        let written = self.bindings.iter().filter_map(|binding| match binding.resource {
            Resource::WriteStream { stream, .. } if binding.reads && binding.writes => Some((binding, stream)),
            _ => None,
        });
        let written: Vec<_> = written.collect();
        if written.is_empty() {
            return Vec::new();
        }
        let Some(texels) = Texels::of(&self.source, self.kernel.info().name) else {
            return written.into_iter().map(|(_, stream)| stream).collect();
        };
        let is_elsewhere = |index: (u32, u32)| texels.get(&index).is_none_or(|is_own| !is_own);
        written.into_iter().filter(|(b, _)| is_elsewhere((b.group, b.index))).map(|(_, stream)| stream).collect()
    }
}

/// The text of a kernel that loads from the copies of these streams, and the name that cannot be told: that of a stream which
/// is handed to a function.
pub(super) fn from_copies(source: &str, streams: &[(String, Texel)]) -> Result<String, usize> {
    let all = words(source);
    let code: Vec<&Word<'_>> = all.iter().filter(|word| word.kind != WordKind::Comment).collect();
    // Bytes to remove and the text in their place, in order.
    let mut edits: Vec<(usize, usize, String)> = Vec::new();
    let shadowed = shadowed(&code);
    for (at, word) in code.iter().enumerate() {
        if !streams.iter().any(|(name, _)| name == word.text) || shadowed.get(at) == Some(&true) {
            continue;
        }
        let before = |back: usize| at.checked_sub(back).map_or("", |at| code[at].text);
        match (before(2), before(1)) {
            ("textureLoad", "(") => {
                edits.push((word.start, word.end(), name_of_copy(word.text)));
                let close = closed(&code[at - 1..]).ok_or(word.start)?;
                edits.push((close, close, ", 0".into()));
            }
            ("textureStore" | "textureDimensions", "(") | (_, "." | "var") => {}
            _ => return Err(word.start),
        }
    }
    edits.sort();
    let mut text = String::with_capacity(source.len() + 64);
    let mut end = 0;
    for (first, last, put) in edits {
        text += &source[end..first];
        text += &put;
        end = last;
    }
    text += &source[end..];
    for (index, (name, texel)) in (FIRST_COPY..).zip(streams) {
        let kind = if *texel == Texel::F32 { "f32" } else { "u32" };
        let copy = name_of_copy(name);
        text += &format!("@group(0) @binding({index}) var {copy}: texture_2d_array<{kind}>;\n");
    }
    Ok(text)
}

/// Of each word, whether it is a name that the function around it declares itself, as a parameter or a variable.
fn shadowed(code: &[&Word<'_>]) -> Vec<bool> {
    let mut all = vec![false; code.len()];
    let mut first = None;
    let mut depth = 0usize;
    for (at, word) in code.iter().enumerate() {
        match word.text {
            "fn" => (first, depth) = (Some(at), 0),
            "{" => depth += 1,
            "}" => {
                depth = depth.saturating_sub(1);
                let Some(begin) = first.filter(|_| depth == 0) else { continue };
                let own: HashSet<&str> =
                    (begin + 2..at).filter(|&i| is_declared(code, i)).map(|i| code[i].text).collect();
                (begin..at).filter(|&i| own.contains(code[i].text)).for_each(|i| all[i] = true);
                first = None;
            }
            _ => {}
        }
    }
    all
}

/// Whether a word of a function is declared there: it is behind `let` or `var`, or a parameter.
fn is_declared(code: &[&Word<'_>], at: usize) -> bool {
    let around = (code[at - 1].text, code.get(at + 1).map(|word| word.text));
    matches!(around, ("let" | "var" | "const", _) | ("(" | ",", Some(":")))
}

/// The first binding of a copy: above all that a user's file may have.
const FIRST_COPY: u32 = 640;

/// The byte of the parenthesis that closes the first.
fn closed(code: &[&Word<'_>]) -> Option<usize> {
    let mut depth = 0usize;
    for word in code {
        match word.text {
            "(" => depth += 1,
            ")" => depth = depth.checked_sub(1)?,
            _ => {}
        }
        if depth == 0 {
            return Some(word.start);
        }
    }
    None
}

/// Values as far as two of them can be told to be equal: each a number. Equal terms are equal numbers.
#[derive(Default)]
struct Texels {
    terms: HashMap<String, usize>,
    /// Of each term, whether its value is the same whenever it is computed in a thread, and whether it depends on the thread.
    known: Vec<(bool, bool)>,
    /// Of each term that is a global.
    globals: HashMap<usize, Handle<GlobalVariable>>,
    /// The texels that are loaded and stored of each global.
    used: Vec<(Handle<GlobalVariable>, usize)>,
    steps: usize,
}

/// Most statements with functions in the places of their calls; of larger kernels nothing is told.
const MOST_STEPS: usize = 1 << 16;

struct Source<'m> {
    module: &'m Module,
    info: &'m ModuleInfo,
}

type Memo = HashMap<Handle<Expression>, usize>;

impl Texels {
    /// Of the textures that a kernel binds, by group and binding, whether all texels that it loads and stores are one of the
    /// thread's own; `None` if that cannot be told.
    fn of(source: &str, entry: &str) -> Option<BTreeMap<(u32, u32), bool>> {
        let module = naga::front::wgsl::parse_str(source).ok()?;
        let info = Validator::new(ValidationFlags::empty(), Capabilities::all()).validate(&module).ok()?;
        let index = module.entry_points.iter().position(|point| point.name == entry)?;
        let function = &module.entry_points[index].function;
        let of = Source { module: &module, info: &info };
        let mut all = Self::default();
        let arguments = (0..function.arguments.len()).map(|i| all.term(format!("argument {i}"), true, true)).collect();
        all.run(&of, function, arguments)?;
        let mut own: BTreeMap<(u32, u32), bool> = BTreeMap::new();
        let mut first: HashMap<Handle<GlobalVariable>, usize> = HashMap::new();
        for &(global, term) in &all.used {
            let Some(binding) = &module.global_variables[global].binding else { continue };
            let is_same = *first.entry(global).or_insert(term) == term && all.known[term] == (true, true);
            *own.entry((binding.group, binding.binding)).or_insert(true) &= is_same;
        }
        Some(own)
    }

    fn term(&mut self, text: String, is_known: bool, is_of_thread: bool) -> usize {
        let next = self.known.len();
        let term = *self.terms.entry(text).or_insert(next);
        if term == next {
            self.known.push((is_known, is_of_thread));
        }
        term
    }

    /// A value of which nothing is known.
    fn other(&mut self) -> usize {
        let text = format!("? {}", self.known.len());
        self.term(text, false, false)
    }

    /// A function of values.
    fn joined(&mut self, what: &str, parts: &[usize]) -> usize {
        let known = parts.iter().all(|&part| self.known[part].0);
        let of_thread = parts.iter().any(|&part| self.known[part].1);
        self.term(format!("{what} {parts:?}"), known, of_thread)
    }

    fn run(&mut self, of: &Source<'_>, function: &Function, arguments: Vec<usize>) -> Option<()> {
        let mut memo = Memo::new();
        self.block(of, function, &function.body, &arguments, &mut memo)
    }

    fn block(
        &mut self,
        of: &Source<'_>,
        function: &Function,
        block: &Block,
        arguments: &[usize],
        memo: &mut Memo,
    ) -> Option<()> {
        for statement in block {
            self.steps += 1;
            if self.steps > MOST_STEPS {
                return None;
            }
            let mut inner = |all: &mut Self, block: &Block| all.block(of, function, block, arguments, memo);
            match statement {
                Statement::Emit(range) => {
                    for handle in range.clone() {
                        if let Expression::ImageLoad { image, coordinate, .. } = function.expressions[handle] {
                            self.touched(of, function, arguments, memo, [image, coordinate])?;
                        }
                    }
                }
                Statement::ImageStore { image, coordinate, .. } => {
                    self.touched(of, function, arguments, memo, [*image, *coordinate])?;
                }
                Statement::Block(block) => inner(self, block)?,
                Statement::If { accept, reject, .. } => {
                    inner(self, accept)?;
                    inner(self, reject)?;
                }
                Statement::Switch { cases, .. } => {
                    for case in cases {
                        inner(self, &case.body)?;
                    }
                }
                Statement::Loop { body, continuing, .. } => {
                    inner(self, body)?;
                    inner(self, continuing)?;
                }
                Statement::Call { function: callee, arguments: given, result } => {
                    let given: Vec<usize> =
                        given.iter().map(|&at| self.value(of, function, at, arguments, memo)).collect();
                    if let Some(result) = result {
                        let term = if is_pure(of.module, &of.info[*callee]) {
                            self.joined(&format!("call {}", callee.index()), &given)
                        } else {
                            self.other()
                        };
                        memo.insert(*result, term);
                    }
                    self.run(of, &of.module.functions[*callee], given)?;
                }
                _ => {}
            }
        }
        Some(())
    }

    /// Notes a texel that is loaded or stored; `None` if the texture is unknown.
    fn touched(
        &mut self,
        of: &Source<'_>,
        function: &Function,
        arguments: &[usize],
        memo: &mut Memo,
        [image, coordinate]: [Handle<Expression>; 2],
    ) -> Option<()> {
        let image = self.value(of, function, image, arguments, memo);
        let texel = self.value(of, function, coordinate, arguments, memo);
        let global = *self.globals.get(&image)?;
        self.used.push((global, texel));
        Some(())
    }

    fn value(
        &mut self,
        of: &Source<'_>,
        function: &Function,
        at: Handle<Expression>,
        arguments: &[usize],
        memo: &mut Memo,
    ) -> usize {
        if let Some(&term) = memo.get(&at) {
            return term;
        }
        let mut parts = |all: &mut Self, what: String, parts: &[Handle<Expression>]| {
            let parts: Vec<usize> = parts.iter().map(|&at| all.value(of, function, at, arguments, memo)).collect();
            all.joined(&what, &parts)
        };
        let term = match &function.expressions[at] {
            Expression::Literal(literal) => self.term(format!("{literal:?}"), true, false),
            Expression::Constant(constant) => self.term(format!("constant {}", constant.index()), true, false),
            Expression::ZeroValue(ty) => self.term(format!("zero {}", ty.index()), true, false),
            Expression::FunctionArgument(index) => {
                arguments.get(*index as usize).copied().unwrap_or_else(|| self.other())
            }
            Expression::GlobalVariable(global) => {
                let space = of.module.global_variables[*global].space;
                let is_kept = match space {
                    AddressSpace::Uniform | AddressSpace::Handle => true,
                    AddressSpace::Storage { access } => !access.contains(StorageAccess::STORE),
                    _ => false,
                };
                let term = self.term(format!("global {}", global.index()), is_kept, false);
                self.globals.insert(term, *global);
                term
            }
            Expression::Load { pointer } => parts(self, "load".into(), &[*pointer]),
            Expression::AccessIndex { base, index } => parts(self, format!("part {index}"), &[*base]),
            Expression::Access { base, index } => parts(self, "element".into(), &[*base, *index]),
            Expression::Splat { size, value } => parts(self, format!("splat {size:?}"), &[*value]),
            Expression::Swizzle { vector, pattern, size } => {
                parts(self, format!("swizzle {:?}", &pattern[..*size as usize]), &[*vector])
            }
            Expression::Compose { ty, components } => parts(self, format!("compose {}", ty.index()), components),
            Expression::Unary { op, expr } => parts(self, format!("{op:?}"), &[*expr]),
            Expression::Binary { op, left, right } => parts(self, format!("{op:?}"), &[*left, *right]),
            Expression::Select { condition, accept, reject } => {
                parts(self, "select".into(), &[*condition, *accept, *reject])
            }
            Expression::As { expr, kind, convert } => parts(self, format!("as {kind:?} {convert:?}"), &[*expr]),
            Expression::Math { fun, arg, arg1, arg2, arg3 } => {
                let given: Vec<_> = [Some(*arg), *arg1, *arg2, *arg3].into_iter().flatten().collect();
                parts(self, format!("{fun:?}"), &given)
            }
            Expression::ImageQuery { image, query } => parts(self, format!("{query:?}"), &[*image]),
            _ => self.other(),
        };
        memo.insert(at, term);
        term
    }
}

/// Whether a function's result depends on nothing but its arguments and what no kernel writes.
fn is_pure(module: &Module, info: &FunctionInfo) -> bool {
    module.global_variables.iter().all(|(handle, global)| {
        let used = info[handle];
        let is_texture = matches!(module.types[global.ty].inner, TypeInner::Image { .. });
        let is_kept = match global.space {
            AddressSpace::Uniform => true,
            // Its size may be asked for.
            AddressSpace::Handle if is_texture => return !used.intersects(GlobalUse::READ | GlobalUse::WRITE),
            AddressSpace::Storage { access } => !access.contains(StorageAccess::STORE),
            _ => false,
        };
        used.is_empty() || is_kept
    })
}

#[cfg(test)]
mod tests;
