use super::*;

const TEXT: &str = "\
struct S { a: u32, b: f32 }
fn f(x: u32) -> u32 {
    var sum = x; let twice = 2u * x;
    for (var i = 0u; i < 4u; i += 1u) {
        let at = sum + i;
        if (at > 2u) { sum = at; } else if (at == 1u) {
            sum += twice;
        }
    }
    switch (sum) {
        case 1u: { return 0u; }
        default: {}
    }
    return sum;
}
";

#[test]
fn statements_begin_where_another_ends_and_not_between_parentheses() {
    let found = Statements::of(TEXT);
    let begins: Vec<(usize, bool, &str)> = found
        .starts
        .iter()
        .map(|start| (start.line, start.is_open, TEXT[start.at..].split([' ', '(']).next().expect("a word")))
        .collect();
    let expected = [
        (2, true, "var"),
        (2, true, "let"),
        (3, true, "for"),
        (4, true, "let"),
        (5, true, "if"),
        (5, true, "sum"),
        (5, false, "else"),
        (6, true, "sum"),
        (9, true, "switch"),
        (10, false, "case"),
        (10, true, "return"),
        (11, false, "default:"),
        (13, true, "return"),
    ];
    assert_eq!(begins, expected);
}

#[test]
fn a_name_can_be_used_in_its_block_behind_its_declaration() {
    let found = Statements::of(TEXT);
    let names = |text: &str| {
        let at = TEXT.find(text).expect("the text");
        let mut names: Vec<&str> = found.names(at).iter().map(|declared| &*declared.name).collect();
        names.sort_unstable();
        names.join(" ")
    };
    assert_eq!(names("var sum"), "x");
    assert_eq!(names("let at"), "i sum twice x");
    assert_eq!(names("sum += twice"), "at i sum twice x");
    assert_eq!(names("return sum"), "sum twice x");
    assert_eq!(names("struct S"), "");
}
