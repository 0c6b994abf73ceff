//! The functions that load from lists in textures, as WGSL.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use naga::valid::FunctionInfo;
use naga::{Expression, GlobalVariable, Handle, Scalar, ScalarKind, Type, TypeInner};

use super::{Index, Place, Shader};
use crate::shared::address::GET_ADDRESS;

/// Bytes of a word: of a texel.
const WORD_BYTES: u32 = 4;

fn scalar_name(scalar: Scalar) -> Result<&'static str, String> {
    match scalar {
        Scalar { kind: ScalarKind::Uint, width: 4 } => Ok("u32"),
        Scalar { kind: ScalarKind::Sint, width: 4 } => Ok("i32"),
        Scalar { kind: ScalarKind::Float, width: 4 } => Ok("f32"),
        other => Err(format!("{other:?} in a list")),
    }
}

/// The WGSL name of a type of 32-bit words.
fn type_name(ty: &TypeInner, name: Option<&str>) -> Result<String, String> {
    match (ty, name) {
        (TypeInner::Struct { .. }, Some(name)) => Ok(name.to_owned()),
        (TypeInner::Scalar(scalar), _) => scalar_name(*scalar).map(str::to_owned),
        (TypeInner::Vector { size, scalar }, _) => Ok(format!("vec{}<{}>", *size as u32, scalar_name(*scalar)?)),
        (other, _) => Err(format!("{other:?} in a list")),
    }
}

impl Shader {
    /// The WGSL of everything that loads from lists need: textures, [`get_address`](crate::shared::address), and a function
    /// for each list and type.
    pub(super) fn accessors(&self) -> Result<String, String> {
        let mut accessors = BTreeMap::new();
        for (function, info) in self.parsed.functions() {
            for (_, expression) in function.expressions.iter() {
                if let Expression::Load { pointer } = *expression
                    && let Some(place) = self.place(function, pointer)?
                {
                    let is_signed = self.is_signed(&place, info);
                    accessors.insert(self.accessor(&place, info), (place, is_signed));
                }
            }
        }
        let mut text = GET_ADDRESS.to_owned();
        for &list in &self.lists {
            text += &self.texture(list)?;
        }
        for (name, (place, is_signed)) in &accessors {
            text += &self.function(name, place, *is_signed)?;
        }
        Ok(text)
    }

    /// The type of a list's elements, and the bytes of each.
    pub(super) fn element(&self, list: Handle<GlobalVariable>) -> Result<(Handle<Type>, u32), String> {
        match self.parsed.module.types[self.parsed.module.global_variables[list].ty].inner {
            TypeInner::Array { base, stride, .. } if stride.is_multiple_of(WORD_BYTES) => Ok((base, stride)),
            ref other => Err(format!("{} is no list, but {other:?}", self.name(list))),
        }
    }

    fn name(&self, list: Handle<GlobalVariable>) -> &str {
        self.parsed.module.global_variables[list].name.as_deref().unwrap_or("unnamed")
    }

    fn is_signed(&self, place: &Place, info: &FunctionInfo) -> bool {
        let Index::Computed(index) = place.index else { return false };
        matches!(info[index].ty.inner_with(&self.parsed.module.types).scalar_kind(), Some(ScalarKind::Sint))
    }

    /// The name of the function that loads what is at a place.
    pub(super) fn accessor(&self, place: &Place, info: &FunctionInfo) -> String {
        let sign = if self.is_signed(place, info) { "_signed" } else { "" };
        let members = match (&place.ty, &place.name) {
            (_, Some(name)) => name.clone(),
            (TypeInner::Vector { size, .. }, _) => format!("{}_words", *size as u32),
            _ => "word".to_owned(),
        };
        format!("load_{members}_{}_of_{}{sign}", place.offset / WORD_BYTES, self.name(place.list))
    }

    /// The texture of a list, and the function that loads a word of it.
    fn texture(&self, list: Handle<GlobalVariable>) -> Result<String, String> {
        let name = self.name(list);
        let at = self.parsed.module.global_variables[list].binding.ok_or("a list without a binding")?;
        Ok(format!(
            "@group({}) @binding({}) var {name}_texture: texture_2d<u32>;\nfn word_of_{name}(i: u32) -> u32 {{\n    let \
             address = get_address(i, textureDimensions({name}_texture).x);\n    return textureLoad({name}_texture, \
             address, 0).x;\n}}\n",
            at.group, at.binding
        ))
    }

    /// The function that loads what is at a place.
    fn function(&self, name: &str, place: &Place, is_signed: bool) -> Result<String, String> {
        let (_, stride) = self.element(place.list)?;
        let result = type_name(&place.ty, place.name.as_deref())?;
        let (index, element) = if is_signed { ("i32", "u32(i)") } else { ("u32", "i") };
        let (stride, offset) = (stride / WORD_BYTES, place.offset / WORD_BYTES);
        let mut value = String::new();
        self.write_value(&mut value, place.list, (&place.ty, place.name.as_deref()), 0)?;
        Ok(format!(
            "fn {name}(i: {index}) -> {result} {{\n    let first = {stride}u * {element} + {offset}u;\n    return \
             {value};\n}}\n"
        ))
    }

    /// Writes a value of a type whose first word is `word` words after `first`.
    fn write_value(
        &self,
        text: &mut String,
        list: Handle<GlobalVariable>,
        (ty, name): (&TypeInner, Option<&str>),
        word: u32,
    ) -> Result<(), String> {
        if let TypeInner::Scalar(scalar) = ty {
            _ = write!(text, "bitcast<{}>(word_of_{}(first + {word}u))", scalar_name(*scalar)?, self.name(list));
            return Ok(());
        }
        _ = write!(text, "{}(", type_name(ty, name)?);
        match ty {
            TypeInner::Vector { size, scalar } => {
                for component in 0..*size as u32 {
                    self.write_value(text, list, (&TypeInner::Scalar(*scalar), None), word + component)?;
                    *text += ", ";
                }
            }
            TypeInner::Struct { members, .. } => {
                for member in members {
                    let ty = &self.parsed.module.types[member.ty];
                    let member = word + member.offset / WORD_BYTES;
                    self.write_value(text, list, (&ty.inner, ty.name.as_deref()), member)?;
                    *text += ", ";
                }
            }
            _ => {}
        }
        *text += ")";
        Ok(())
    }
}
