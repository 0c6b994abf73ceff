//! What a kernel does with its streams.

use std::collections::{BTreeMap, BTreeSet};

use naga::{Block, Expression, Function, Handle, Literal, Module, Statement};

use crate::program::Kernel;
use crate::shader::ShaderError;
use crate::tables::stream::Stream;

/// What a kernel does with its streams.
pub(super) struct Uses {
    /// The streams whose texels it loads.
    pub(super) loaded: BTreeSet<Stream>,
    /// Whether it asks a stream for the image's size.
    pub(super) asks_size: bool,
    /// For each block of statements, the layers that it stores.
    stored: Vec<BTreeMap<Stream, BTreeSet<u32>>>,
}

impl Uses {
    pub(super) fn of(kernel: Kernel, module: &Module) -> Result<Self, ShaderError> {
        let mut uses = Self { loaded: BTreeSet::new(), asks_size: false, stored: Vec::new() };
        let entries = module.entry_points.iter().map(|entry| &entry.function);
        for function in module.functions.iter().map(|(_, function)| function).chain(entries) {
            for (_, expression) in function.expressions.iter() {
                match *expression {
                    Expression::ImageLoad { image, .. } => {
                        uses.loaded.extend(stream_of(kernel, module, function, image));
                    }
                    Expression::ImageQuery { .. } => uses.asks_size = true,
                    _ => {}
                }
            }
            uses.visit(kernel, module, function, &function.body).map_err(|message| {
                let message = message.to_owned();
                ShaderError::Invalid { kernel: kernel.name(), message }
            })?;
        }
        Ok(uses)
    }

    fn visit(
        &mut self,
        kernel: Kernel,
        module: &Module,
        function: &Function,
        block: &Block,
    ) -> Result<(), &'static str> {
        let mut stored: BTreeMap<Stream, BTreeSet<u32>> = BTreeMap::new();
        for statement in block {
            match statement {
                Statement::Block(inner) => self.visit(kernel, module, function, inner)?,
                Statement::If { accept, reject, .. } => {
                    self.visit(kernel, module, function, accept)?;
                    self.visit(kernel, module, function, reject)?;
                }
                Statement::Switch { cases, .. } => {
                    for case in cases {
                        self.visit(kernel, module, function, &case.body)?;
                    }
                }
                Statement::Loop { body, continuing, .. } => {
                    self.visit(kernel, module, function, body)?;
                    self.visit(kernel, module, function, continuing)?;
                }
                Statement::ImageStore { image, array_index, .. } => {
                    let stream = stream_of(kernel, module, function, *image).ok_or("it writes what is no stream")?;
                    stored.entry(stream).or_default().insert(layer(module, function, *array_index)?);
                }
                _ => {}
            }
        }
        self.stored.push(stored);
        Ok(())
    }

    /// The streams that it writes, in table order.
    pub(super) fn written(&self) -> Vec<Stream> {
        let all: BTreeSet<Stream> = self.stored.iter().flat_map(BTreeMap::keys).copied().collect();
        all.into_iter().collect()
    }

    /// Whether a fragment that writes one of these streams writes all layers of `stream`: every block of statements that
    /// stores a layer of one of them stores them all.
    pub(super) fn is_complete(&self, stream: Stream, targets: &[Stream]) -> bool {
        let stores_any = |block: &&BTreeMap<_, _>| targets.iter().any(|target| block.contains_key(target));
        let stores_all = |block: &BTreeMap<Stream, BTreeSet<u32>>| {
            block.get(&stream).is_some_and(|layers| layers.len() == stream.layers())
        };
        self.stored.iter().filter(stores_any).all(stores_all)
    }
}

/// The stream that an expression names.
pub(super) fn stream_of(
    kernel: Kernel,
    module: &Module,
    function: &Function,
    image: Handle<Expression>,
) -> Option<Stream> {
    let Expression::GlobalVariable(global) = function.expressions[image] else { return None };
    let name = module.global_variables[global].name.as_deref()?;
    kernel.program().stream(kernel.bound(name))
}

/// The layer that an expression names.
pub(super) fn layer(
    module: &Module,
    function: &Function,
    index: Option<Handle<Expression>>,
) -> Result<u32, &'static str> {
    let index = index.ok_or("a stream without layers")?;
    let literal = match function.expressions[index] {
        Expression::Literal(literal) => Some(literal),
        Expression::Constant(constant) => match module.global_expressions[module.constants[constant].init] {
            Expression::Literal(literal) => Some(literal),
            _ => None,
        },
        _ => None,
    };
    match literal {
        Some(Literal::U32(layer)) => Ok(layer),
        Some(Literal::I32(layer)) => u32::try_from(layer).map_err(|_| "a layer below 0"),
        _ => Err("a layer of a stream that is no constant"),
    }
}
