//! Rewrites JSON that is valid or harmless but that `gltf-json` rejects.

use std::borrow::Cow;
use std::collections::BTreeMap;

use serde_json::value::RawValue;

/// Rewrites integers that have a fraction or an exponent (`1.0`, `1e0`, `10e-1`), as JSON allows, without them. Nothing
/// else changes, and what follows keeps its column if possible.
pub(super) fn whole_numbers(text: &str) -> Cow<'_, str> {
    let bytes = text.as_bytes();
    let mut out = String::new();
    // How much of `text` has been copied.
    let mut copied = 0;
    let mut i = 0;
    while let Some(&byte) = bytes.get(i) {
        let rest = bytes.get(i..).unwrap_or_default();
        let length = match byte {
            b'"' => string_length(rest),
            b'-' | b'0'..=b'9' => rest.iter().take_while(|b| b"+-.eE0123456789".contains(b)).count(),
            _ => 1,
        };
        if byte.is_ascii_digit()
            && let Some(token) = text.get(i..i + length)
            && let Some(whole) = whole(token)
        {
            out.push_str(text.get(copied..i).unwrap_or_default());
            out.push_str(&format!("{whole:<length$}"));
            copied = i + length;
        }
        i += length;
    }
    if copied == 0 {
        return Cow::Borrowed(text);
    }
    out.push_str(text.get(copied..).unwrap_or_default());
    Cow::Owned(out)
}

/// The length of a string, from its opening quote to the next one that is not escaped.
fn string_length(bytes: &[u8]) -> usize {
    let mut i = 1;
    loop {
        match bytes.get(i) {
            Some(b'\\') => i += 2,
            Some(b'"') => return i + 1,
            Some(_) => i += 1,
            None => return bytes.len(),
        }
    }
}

/// The value of an unsigned number that is an integer but not written as one and that f64 represents exactly, so that
/// readers of floats get the same value.
fn whole(token: &str) -> Option<u64> {
    let (mantissa, exponent) = token.split_once(['e', 'E']).unwrap_or((token, "0"));
    let (integer, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let is_number = |digits: &str| !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit());
    let is_plain = integer.len() == token.len();
    if is_plain || !is_number(integer) || integer.len() > 1 && integer.starts_with('0') {
        return None;
    }
    if mantissa.contains('.') && !is_number(fraction) {
        return None;
    }
    if !is_number(exponent.strip_prefix(['+', '-']).unwrap_or(exponent)) {
        return None;
    }
    // Trailing zeros of the fraction do not matter.
    let fraction = fraction.trim_end_matches('0');
    let digits = format!("{integer}{fraction}");
    let digits = digits.trim_start_matches('0');
    if digits.is_empty() {
        return Some(0);
    }
    let exponent = exponent.parse::<i64>().ok()?.checked_sub(i64::try_from(fraction.len()).ok()?)?;
    let kept = digits.trim_end_matches('0');
    let exponent = exponent.checked_add(i64::try_from(digits.len() - kept.len()).ok()?)?;
    let exponent = u32::try_from(exponent).ok().filter(|&exponent| exponent <= 15)?;
    let value = kept.parse::<u64>().ok()?.checked_mul(10_u64.pow(exponent))?;
    (value <= 1 << 53).then_some(value)
}

/// The same JSON with an empty node list in every scene that has none, since a scene may be empty, and with empty
/// animations, since their channels need not have a node, and nothing in them is used. Everything else is unchanged.
/// `None` if the JSON has another structure.
pub(super) fn scenes_and_animations(text: &str) -> Option<String> {
    type Object = BTreeMap<String, Box<RawValue>>;
    let mut root: Object = serde_json::from_str(text).ok()?;
    if let Some(raw) = root.get_mut("scenes") {
        let mut scenes: Vec<Object> = serde_json::from_str(raw.get()).ok()?;
        for scene in &mut scenes {
            if !scene.contains_key("nodes") {
                scene.insert("nodes".into(), RawValue::from_string("[]".into()).ok()?);
            }
        }
        *raw = serde_json::value::to_raw_value(&scenes).ok()?;
    }
    if let Some(raw) = root.get_mut("animations") {
        let animations: Vec<&RawValue> = serde_json::from_str(raw.get()).ok()?;
        let empty = animations.iter().map(|_| r#"{"channels":[],"samplers":[]}"#).collect::<Vec<_>>().join(",");
        *raw = RawValue::from_string(format!("[{empty}]")).ok()?;
    }
    serde_json::to_string(&root).ok()
}
