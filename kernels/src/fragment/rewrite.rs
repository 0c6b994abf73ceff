//! Rewrites a module: its loads and stores of texels become those of private variables.
//!
//! Each mention of a global in a WGSL text is an expression of its own in naga's module, so the texture that a load or a
//! store mentions can be replaced in place.

use std::collections::BTreeMap;

use naga::{Block, Expression, Function, GlobalVariable, Handle, ImageQuery, Literal, Module, Span, Statement};

use super::uses::{self, Uses};
use super::{BODY, input, is_written, value};
use crate::program::Kernel;
use crate::shader::rewritten;
use crate::tables::stream::Stream;

/// The variables that an entry point's text declares.
struct Variables {
    /// A private variable for each layer.
    values: BTreeMap<(Stream, u32), Handle<GlobalVariable>>,
    /// Whether a stream was written, where that is asked for.
    written: BTreeMap<Stream, Handle<GlobalVariable>>,
    /// The texture that tells the image's size.
    size: Handle<GlobalVariable>,
}

/// Makes the compute entry point an ordinary function, [`BODY`], and every access to a stream one to the variables that the
/// other entry point declares.
pub(super) fn rewrite(kernel: Kernel, uses: &Uses, module: &mut Module) -> Result<(), String> {
    let name = kernel.info().name;
    let entry = module.entry_points.iter().position(|entry| entry.name == name).ok_or("no entry point")?;
    let mut function = module.entry_points.remove(entry).function;
    function.arguments.iter_mut().for_each(|argument| argument.binding = None);
    let body = module.functions.iter_mut().find(|(_, function)| function.name.as_deref() == Some(BODY));
    let (_, body) = body.ok_or("no function for the body")?;
    *body = Function { name: body.name.take(), ..function };

    let variables = Variables::find(kernel, uses, module)?;
    let functions: Vec<_> = module.functions.iter().map(|(handle, _)| handle).collect();
    for handle in functions {
        let mut function = module.functions[handle].clone();
        variables.rewrite(kernel, module, &mut function)?;
        *module.functions.get_mut(handle) = function;
    }
    Ok(())
}

impl Variables {
    fn find(kernel: Kernel, uses: &Uses, module: &Module) -> Result<Self, String> {
        let global = |name: &str| {
            let found = module.global_variables.iter().find(|(_, global)| global.name.as_deref() == Some(name));
            found.map(|(handle, _)| handle)
        };
        let touched = uses.loaded.iter().copied().chain(uses.written());
        let (mut values, mut written) = (BTreeMap::new(), BTreeMap::new());
        for stream in touched {
            for layer in 0..stream.layers() {
                let name = value(stream, layer);
                let handle = global(&name).ok_or_else(|| format!("no variable {name}"))?;
                values.insert((stream, layer as u32), handle);
            }
            written.extend(global(&is_written(stream)).map(|handle| (stream, handle)));
        }
        let state = kernel.program().state_stream().ok_or("no states")?;
        let size = global(&input(state)).ok_or("no texture of states")?;
        Ok(Self { values, written, size })
    }

    fn value(&self, stream: Stream, layer: u32) -> Result<Expression, String> {
        let handle = self.values.get(&(stream, layer)).ok_or_else(|| format!("{stream:?} has no layer {layer}"))?;
        Ok(Expression::GlobalVariable(*handle))
    }

    fn rewrite(&self, kernel: Kernel, module: &Module, function: &mut Function) -> Result<(), String> {
        let body = self.stores(kernel, module, function, &function.body.clone())?;
        function.body = body;
        let expressions: Vec<_> = function.expressions.iter().map(|(handle, e)| (handle, e.clone())).collect();
        for (handle, expression) in expressions {
            match expression {
                Expression::ImageLoad { image, array_index, .. } => {
                    let stream =
                        uses::stream_of(kernel, module, function, image).ok_or("it reads what is no stream")?;
                    let layer = uses::layer(module, function, array_index)?;
                    *function.expressions.get_mut(image) = self.value(stream, layer)?;
                    *function.expressions.get_mut(handle) = Expression::Load { pointer: image };
                }
                Expression::ImageQuery { image, query: ImageQuery::Size { level } } => {
                    uses::stream_of(kernel, module, function, image).ok_or("it measures what is no stream")?;
                    *function.expressions.get_mut(image) = Expression::GlobalVariable(self.size);
                    let query = ImageQuery::Size { level };
                    *function.expressions.get_mut(handle) = Expression::ImageQuery { image, query };
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// The block with stores to variables in place of those to streams.
    fn stores(&self, kernel: Kernel, module: &Module, function: &mut Function, block: &Block) -> Result<Block, String> {
        rewritten(block, &mut |rewritten, statement, span| {
            let Statement::ImageStore { image, array_index, value, .. } = statement else {
                rewritten.push(statement.clone(), span);
                return Ok(());
            };
            let stream = uses::stream_of(kernel, module, function, *image).ok_or("it writes what is no stream")?;
            let layer = uses::layer(module, function, *array_index)?;
            if let Some(&flag) = self.written.get(&stream) {
                let mut append = |expression| function.expressions.append(expression, Span::UNDEFINED);
                let pointer = append(Expression::GlobalVariable(flag));
                let value = append(Expression::Literal(Literal::Bool(true)));
                rewritten.push(Statement::Store { pointer, value }, span);
            }
            *function.expressions.get_mut(*image) = self.value(stream, layer)?;
            rewritten.push(Statement::Store { pointer: *image, value: *value }, span);
            Ok(())
        })
    }
}
