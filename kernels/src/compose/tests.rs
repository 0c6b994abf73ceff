use super::condition::holds;
use super::*;

fn composed(modules: &[(&str, &'static str)], options: &[(&str, bool)]) -> Result<String, ComposeError> {
    let source = |name: &str| modules.iter().find(|(module, _)| *module == name).map(|&(_, text)| text);
    let option = |name: &str| options.iter().find(|(option, _)| *option == name).map(|&(_, is_on)| is_on);
    compose("main", "main", &source, &option)
}

/// Composes a single module.
fn alone(text: &'static str, options: &[(&str, bool)]) -> String {
    composed(&[("main", text)], options).expect("a text")
}

#[test]
fn conditions_bind_as_in_wgsl() {
    let option = |name: &str| match name {
        "yes" => Some(true),
        "no" => Some(false),
        _ => None,
    };
    for (expression, expected) in [
        ("yes", true),
        ("!yes", false),
        ("!!yes", true),
        ("no || yes && no", false),
        ("yes || yes && no", true),
        ("(yes || yes) && no", false),
        ("!(no || no)", true),
    ] {
        assert_eq!(holds(expression, &option), Ok(expected), "{expression}");
    }
    for (expression, message) in [
        ("maybe", "no option is named \"maybe\""),
        ("(yes", "a parenthesis is not closed"),
        ("yes &&", "the expression ends too early"),
        ("", "the expression ends too early"),
        ("yes no", "\"no\" after the end of the expression"),
        ("yes & no", "\"&\" after the end of the expression"),
    ] {
        assert_eq!(holds(expression, &option), Err(message.into()), "{expression}");
    }
}

const ARMS: &str = "
// Above both.
@if(on) const PLACE: u32 = 1u;
@else const PLACE: u32 = 2u;

struct Pair {
    first: u32,
    // Only then.
    @if(on) second: array<vec2<u32>, 4>,
    @if(!on) last: u32
}

fn main() {
    let pair = Pair();
    @if(on) if (PLACE > 0u) {
        one();
    } else if (PLACE > 1u) {
        two();
    } else {
        three();
    }
    @else {
        four(PLACE); // stays
    }
    for (var i = 0u; i < 4u; i++) {
        @if(on) @if(deep) five();
        @else six();
    }
}
";

#[test]
fn an_arm_is_a_declaration_a_member_or_a_statement_with_all_its_arms() {
    let on = alone(ARMS, &[("on", true), ("deep", true)]);
    assert_eq!(
        on,
        "// Above both.
const PLACE: u32 = 1u;

struct Pair {
    first: u32,
    // Only then.
    second: array<vec2<u32>, 4>,
}

fn main() {
    let pair = Pair();
    if (PLACE > 0u) {
        one();
    } else if (PLACE > 1u) {
        two();
    } else {
        three();
    }
    for (var i = 0u; i < 4u; i++) {
        five();
    }
}
"
    );
    let off = alone(ARMS, &[("on", false), ("deep", true)]);
    assert_eq!(
        off,
        "// Above both.
const PLACE: u32 = 2u;

struct Pair {
    first: u32,
    last: u32
}

fn main() {
    let pair = Pair();
    {
        four(PLACE); // stays
    }
    for (var i = 0u; i < 4u; i++) {
        six();
    }
}
"
    );
}

#[test]
fn of_several_arms_the_first_that_holds_is_kept() {
    let text = "fn main() {\n    @if(a) x();\n    @else @if(b) y();\n    @else z();\n}\n";
    let two = "fn main() {\n    @if(a) x();\n    @else @if(b) y();\n}\n";
    let members = "struct S {\n    @if(a) x: u32,\n    @else @if(b) y: u32,\n    @else z: u32\n}\nfn main() { S(); }";
    for (a, b, kept) in [(true, true, 'x'), (true, false, 'x'), (false, true, 'y'), (false, false, 'z')] {
        let options = [("a", a), ("b", b)];
        assert_eq!(alone(text, &options), format!("fn main() {{\n    {kept}();\n}}\n"), "{a} {b}");
        let rest = if kept == 'z' { String::new() } else { format!("    {kept}();\n") };
        assert_eq!(alone(two, &options), format!("fn main() {{\n{rest}}}\n"), "{a} {b}");
        let names = ['x', 'y', 'z'].map(|name| alone(members, &options).contains(&format!("{name}: u32")));
        assert_eq!(names, ['x', 'y', 'z'].map(|name| name == kept), "{a} {b}");
        let option = |name: &str| options.iter().find(|(option, _)| *option == name).map(|&(_, is_on)| is_on);
        let out = left_out("main", text, &option).expect("arms");
        let arms = ["@if(a) x();", "@else @if(b) y();", "@else z();"];
        let expected: Vec<_> = arms.into_iter().filter(|arm| !arm.contains(&format!("{kept}("))).collect();
        assert_eq!(out.into_iter().map(|range| &text[range]).collect::<Vec<_>>(), expected, "{a} {b}");
    }
}

#[test]
fn only_what_the_entry_reaches_is_there() {
    let modules = [
        (
            "main",
            "import package::tools::{twice, UNUSED};\n@if(far) import package::nowhere::{gone};\n\n\
                  var<private> seen: u32;\nvar<private> unseen: u32;\n\
                  @compute @workgroup_size(8)\nfn main() {\n    seen = twice(1u).unseen;\n}\n",
        ),
        (
            "tools",
            "// Says so.\nfn twice(x: u32) -> u32 {\n    return FACTOR * x; /* not UNUSED */\n}\n\
                   const FACTOR = 2u;\nconst UNUSED = 3u;\n",
        ),
    ];
    let text = composed(&modules, &[("far", false)]).expect("a text");
    assert_eq!(
        text,
        "var<private> seen: u32;

@compute @workgroup_size(8)
fn main() {
    seen = twice(1u).unseen;
}

// Says so.
fn twice(x: u32) -> u32 {
    return FACTOR * x; /* not UNUSED */
}

const FACTOR = 2u;
"
    );
}

#[test]
fn what_is_wrong_is_said_with_its_place() {
    let one = |text: &'static str| composed(&[("main", text), ("tools", "fn f() {}\nfn main() {}")], &[("on", true)]);
    for (text, message) in [
        ("fn other() {}", "main has no function \"main\""),
        ("fn main() {\n    @if(of) a();\n}", "main, line 2: no option is named \"of\""),
        ("fn main() {\n    @if on a();\n}", "main, line 2: @if without (expression)"),
        ("fn main() {\n    @else a();\n}", "main, line 2: @else without an @if right before it"),
        (
            "fn main() {\n    @if(on) a();\n    b();\n    @else c();\n}",
            "main, line 4: @else without an @if right before it",
        ),
        ("fn main() {\n    @if(on) @else a();\n}", "main, line 2: @else without an @if right before it"),
        ("fn main() {\n    @if(on)\n}", "main, line 2: nothing complete comes after this"),
        ("fn main() {}\nimport tools::f;", "main, line 2: neither an import nor a declaration with a name"),
        ("fn main() {}\nfn () {}", "main, line 2: neither an import nor a declaration with a name"),
        (
            "fn main() {}\n\nfn f() {",
            "main, line 3: it does not end: the brackets after it do not match, or a semicolon is missing",
        ),
        ("import package::no::{f};\nfn main() { f(); }", "main imports from \"no\", which is no module"),
        (
            "import package::tools::g;\nfn main() { g(); }",
            "main imports \"g\" from tools, which does not declare it with these options",
        ),
        ("fn main() {}\nfn main() {}", "\"main\" is declared twice, in main and in main"),
    ] {
        assert_eq!(one(text).map_err(|e| e.to_string()), Err(message.to_owned()), "{text}");
    }
    let twice = "import package::tools::f;\nfn main() { f(); g(); }\nfn g() {}";
    let tools = "fn f() { g(); }\nfn g() {}";
    let error = composed(&[("main", twice), ("tools", tools)], &[]).expect_err("a clash");
    assert_eq!(error.to_string(), "\"g\" is declared twice, in main and in tools");
}
