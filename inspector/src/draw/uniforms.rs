//! Checks that uniforms have the memory layout that their shaders declare.

/// Asserts that a WGSL struct has these members, in this order, at these offsets, and this size.
pub(super) fn assert_lies_as(source: &str, name: &str, members: &[(&str, usize)], size: usize) {
    let module = naga::front::wgsl::parse_str(source).expect("valid WGSL");
    let found = module.types.iter().find_map(|(_, ty)| match &ty.inner {
        naga::TypeInner::Struct { members, span } if ty.name.as_deref() == Some(name) => Some((members, *span)),
        _ => None,
    });
    let (there, span) = found.unwrap_or_else(|| panic!("no struct {name}"));
    let there: Vec<_> = there.iter().map(|m| (m.name.as_deref().unwrap_or(""), m.offset as usize)).collect();
    assert_eq!(there, members, "{name}");
    assert_eq!(span as usize, size, "{name}");
}
