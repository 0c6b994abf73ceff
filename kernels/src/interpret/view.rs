//! The variables of a thread where it is.

use naga::{Expression, Handle, Type, TypeInner, UniqueArena};

use super::Interpreter;
use super::code::{Global, Kind, Slot, kind, slots};
use super::compile::line_of;
use super::flow::After;
use super::machine::{Frame, Machine};
use crate::shader::{By, Declared, Statements, watched_by};
use crate::tables::stream::Stream;

/// A thread where it is.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct View {
    /// The functions that it is in, the innermost first.
    pub frames: Vec<FrameView>,
    /// Variables of the module: those of the thread, and those of its workgroup.
    pub module: Vec<Variable>,
    /// The element's own components.
    pub streams: Vec<StreamView>,
    /// What the thread is, in a pass: its built-in values, and the parameters of its launch.
    pub thread: Vec<Variable>,
    /// The value of the expression that is evaluated there.
    pub evaluated: Option<Variable>,
}

/// A function that a thread is in.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameView {
    /// Its name.
    pub function: String,
    /// The line of the composed source, from 0.
    pub line: usize,
    /// Its arguments and variables, and what `let` names, as far as they can be used here; the first declared first.
    pub variables: Vec<Variable>,
}

/// A variable or another value with a name.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// Its name; `[2]` in an array, and `x` in a vector.
    pub name: String,
    /// Its type in WGSL.
    pub of: String,
    /// Its value.
    pub value: Shown,
}

/// A value.
#[derive(Clone, Debug, PartialEq)]
pub enum Shown {
    /// A scalar, by its bits.
    Scalar(Kind, u32),
    /// A vector, matrix, array or structure.
    Parts(Vec<Variable>),
    /// In words.
    Told(String),
}

/// A component of a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StreamView {
    /// The stream.
    pub stream: Stream,
    /// The layer.
    pub layer: usize,
    /// Its bits before the pass.
    pub before: u32,
    /// Its bits now.
    pub now: u32,
}

/// Most scalars of all variables of a view.
const MOST_SCALARS: usize = 1 << 16;

impl Shown {
    /// The value on one line.
    #[must_use]
    pub fn told(&self) -> String {
        match self {
            Self::Scalar(kind, bits) => kind.told(*bits),
            Self::Told(text) => text.clone(),
            Self::Parts(parts) => {
                let first = parts.iter().take(8).map(|part| part.value.told());
                let mut told = first.collect::<Vec<_>>().join(", ");
                if parts.len() > 8 {
                    told += ", …";
                }
                format!("({told})")
            }
        }
    }
}

/// A type as WGSL writes it.
fn name_of(types: &UniqueArena<Type>, inner: &TypeInner, name: Option<&str>) -> String {
    let scalar = |inner: &TypeInner| match kind(inner) {
        Kind::F32 => "f32",
        Kind::U32 => "u32",
        Kind::I32 => "i32",
        Kind::Bool => "bool",
    };
    let of = |base: Handle<Type>| name_of(types, &types[base].inner, types[base].name.as_deref());
    match *inner {
        TypeInner::Scalar(_) => scalar(inner).to_owned(),
        TypeInner::Atomic(_) => format!("atomic<{}>", scalar(inner)),
        TypeInner::Vector { size, .. } => format!("vec{}<{}>", size as u8, scalar(inner)),
        TypeInner::Matrix { columns, rows, .. } => format!("mat{}x{}<f32>", columns as u8, rows as u8),
        TypeInner::Array { base, size: naga::ArraySize::Constant(count), .. } => {
            format!("array<{}, {count}>", of(base))
        }
        TypeInner::Pointer { base, .. } => format!("ptr<{}>", of(base)),
        TypeInner::Image { .. } => "texture".to_owned(),
        _ => name.unwrap_or("a value").to_owned(),
    }
}

/// Values as their types say.
struct Reader<'a> {
    types: &'a UniqueArena<Type>,
    /// Scalars that may still be shown.
    left: usize,
}

impl Reader<'_> {
    fn shown(&mut self, inner: &TypeInner, values: &[Slot]) -> Shown {
        if values.len() > self.left {
            return Shown::Told("too many values to show".into());
        }
        match *inner {
            TypeInner::Scalar(_) | TypeInner::Atomic(_) => {
                self.left -= 1;
                values.first().map_or(Shown::Told(String::new()), |slot| Shown::Scalar(kind(inner), slot.bits))
            }
            TypeInner::Vector { scalar, .. } => {
                let part = TypeInner::Scalar(scalar);
                let names = ["x", "y", "z", "w"].into_iter().map(str::to_owned);
                self.parts(names.zip(values).map(|(name, value)| (name, part.clone(), vec![*value])).collect())
            }
            TypeInner::Matrix { rows, scalar, .. } => {
                let part = TypeInner::Vector { size: rows, scalar };
                let columns = values.chunks(rows as usize).enumerate();
                self.parts(columns.map(|(at, column)| (format!("[{at}]"), part.clone(), column.to_vec())).collect())
            }
            TypeInner::Array { base, .. } => {
                let part = &self.types[base].inner;
                let width = slots(self.types, part).unwrap_or(0).max(1) as usize;
                let parts = values.chunks(width).enumerate();
                self.parts(parts.map(|(at, own)| (format!("[{at}]"), part.clone(), own.to_vec())).collect())
            }
            TypeInner::Struct { ref members, .. } => {
                let mut first = 0;
                let mut parts = Vec::new();
                for (at, member) in members.iter().enumerate() {
                    let part = &self.types[member.ty].inner;
                    let end = first + slots(self.types, part).unwrap_or(0) as usize;
                    let name = member.name.clone().unwrap_or_else(|| at.to_string());
                    parts.push((name, part.clone(), values.get(first..end).unwrap_or_default().to_vec()));
                    first = end;
                }
                self.parts(parts)
            }
            _ => Shown::Told(name_of(self.types, inner, None)),
        }
    }

    fn parts(&mut self, parts: Vec<(String, TypeInner, Vec<Slot>)>) -> Shown {
        let part = |(name, inner, values): (String, TypeInner, Vec<Slot>)| {
            let of = name_of(self.types, &inner, None);
            Variable { name, of, value: self.shown(&inner, &values) }
        };
        Shown::Parts(parts.into_iter().map(part).collect())
    }

    fn variable(&mut self, name: &str, of: String, inner: &TypeInner, values: &[Slot]) -> Variable {
        Variable { name: name.to_owned(), of, value: self.shown(inner, values) }
    }
}

impl Interpreter {
    /// Whether an expression is evaluated before a statement.
    pub(super) fn evaluates(&self) -> bool {
        let functions = self.module.functions.iter().map(|(_, function)| function);
        let mut all = functions.chain(self.module.entry_points.iter().map(|entry| &entry.function));
        all.any(|function| function.named_expressions.values().any(|name| watched_by(name).is_some()))
    }
}

impl<'a> Machine<'a> {
    /// The thread where it is, without its streams.
    pub(super) fn view(&self) -> View {
        let statements = Statements::of(&self.kernel.source);
        let mut reader = Reader { types: &self.kernel.module.types, left: MOST_SCALARS };
        let callers = self.thread.todo.iter().rev().filter_map(|todo| match &todo.after {
            After::Call { caller, .. } => Some(*caller),
            _ => None,
        });
        let frames: Vec<Frame<'a>> = self.thread.frame.into_iter().chain(callers).collect();
        let places = std::iter::once(self.thread.at).chain(self.thread.calls.iter().rev().copied());
        let mut view = View::default();
        for (frame, statement) in frames.into_iter().zip(places) {
            let byte = self.kernel.code.statements.get(statement as usize).map_or(0, |span| span.start);
            let function = frame.function.name.clone();
            let function = function.unwrap_or_else(|| self.kernel.kernel.info().name.to_owned());
            if view.frames.is_empty() {
                let named = frame.function.named_expressions.iter().find(|(_, name)| watched_by(name).is_some());
                view.evaluated = named.and_then(|(at, _)| self.named(&frame, *at, "", &mut reader));
            }
            let mut names = statements.names(byte);
            names.retain(|declared| watched_by(&declared.name).is_none());
            names.sort_by_key(|declared| declared.at);
            let variables = names.into_iter().filter_map(|declared| self.variable(&frame, declared, &mut reader));
            let line = line_of(&self.kernel.source, byte);
            view.frames.push(FrameView { function, line, variables: variables.collect() });
        }
        view.module = self.module(&mut reader);
        view
    }

    /// A name that can be used; `None` if it has no value of its own.
    fn variable(&self, frame: &Frame<'a>, declared: &Declared, reader: &mut Reader<'_>) -> Option<Variable> {
        let (function, types) = (frame.function, &self.kernel.module.types);
        let name = declared.name.as_str();
        let own = |base: usize, place: u32, width: u32| {
            let first = base + place as usize;
            self.thread.stack.get(first..first + width as usize).unwrap_or_default()
        };
        if declared.by == By::Variable {
            let is_it = |(handle, local): &(Handle<naga::LocalVariable>, &naga::LocalVariable)| {
                let span = function.local_variables.get_span(*handle).to_range().unwrap_or_default();
                local.name.as_deref() == Some(name) && (span.contains(&declared.at) || span.start == declared.at)
            };
            let named = |(_, local): &(_, &naga::LocalVariable)| local.name.as_deref() == Some(name);
            let all = || function.local_variables.iter();
            let (handle, local) = all().find(is_it).or_else(|| all().find(named))?;
            let place = frame.body.locals.get(handle.index())?;
            let of = name_of(types, &types[local.ty].inner, types[local.ty].name.as_deref());
            return Some(reader.variable(name, of, &types[local.ty].inner, own(frame.base, place.place, place.width)));
        }
        if declared.by == By::Argument {
            let index = function.arguments.iter().position(|argument| argument.name.as_deref() == Some(name))?;
            let place = frame.body.arguments.get(index)?;
            let of = &types[function.arguments[index].ty];
            let told = name_of(types, &of.inner, of.name.as_deref());
            return Some(reader.variable(name, told, &of.inner, own(frame.base, place.place, place.width)));
        }
        // The expression's first byte is behind the name.
        let line_end = self.kernel.source[declared.at..].find(';').map_or(usize::MAX, |end| declared.at + end);
        let is_it = |handle: Handle<Expression>| {
            let span = function.expressions.get_span(handle).to_range().unwrap_or_default();
            (declared.at..=line_end).contains(&span.start)
        };
        let named = || function.named_expressions.iter().filter(|(_, of)| *of == name).map(|(handle, _)| *handle);
        let handle = named().find(|&handle| is_it(handle)).or_else(|| named().next())?;
        self.named(frame, handle, name, reader)
    }

    /// An expression with a name.
    fn named(
        &self,
        frame: &Frame<'a>,
        at: Handle<Expression>,
        name: &str,
        reader: &mut Reader<'_>,
    ) -> Option<Variable> {
        let (kernel, types) = (self.kernel, &self.kernel.module.types);
        let info = match frame.body.handle {
            Some(handle) => &kernel.info[handle],
            None => kernel.info.get_entry_point(kernel.entry),
        };
        let width = frame.body.cells.get(at.index())?.width;
        let resolved = &info[at].ty;
        let type_name = resolved.handle().and_then(|handle| types[handle].name.as_deref());
        let inner = resolved.inner_with(types);
        let of = name_of(types, inner, type_name);
        if width == 0 {
            return Some(Variable { name: name.to_owned(), of, value: Shown::Told("no value of its own".into()) });
        }
        let values: Vec<Slot> = (0..width).map(|lane| self.get(frame, at, lane)).collect();
        Some(reader.variable(name, of, inner, &values))
    }

    /// The variables of the module.
    fn module(&self, reader: &mut Reader<'_>) -> Vec<Variable> {
        let module = &self.kernel.module;
        let mut found = Vec::new();
        for ((_, variable), global) in module.global_variables.iter().zip(&self.kernel.code.globals) {
            let ty = &module.types[variable.ty];
            let width = slots(&module.types, &ty.inner).unwrap_or(0) as usize;
            let values = match *global {
                Global::Private(first) => self.thread.private.get(first as usize..first as usize + width),
                Global::Workgroup(first) => {
                    let memory = self.group.as_ref().map(|group| group.memory());
                    memory.and_then(|memory| memory.get(first as usize..first as usize + width))
                }
                _ => None,
            };
            if let (Some(values), Some(name)) = (values, &variable.name) {
                let of = name_of(&module.types, &ty.inner, ty.name.as_deref());
                found.push(reader.variable(name, of, &ty.inner, values));
            }
        }
        found
    }
}
