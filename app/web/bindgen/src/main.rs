//! `bindgen IN.wasm FOLDER`: the module for browsers, and the JavaScript that loads it.

use wasm_bindgen_cli_support::Bindgen;

fn main() {
    let mut arguments = std::env::args().skip(1);
    let (Some(module), Some(folder), None) = (arguments.next(), arguments.next(), arguments.next()) else {
        eprintln!("usage: bindgen IN.wasm FOLDER");
        std::process::exit(2);
    };
    // Names of functions are a sixth of what is fetched, and for debuggers only.
    let mut bindgen = Bindgen::new();
    bindgen.input_path(module).typescript(false).remove_name_section(true);
    let generated = bindgen.web(true).and_then(|b| b.generate(folder));
    if let Err(error) = generated {
        eprintln!("{error:#}");
        std::process::exit(1);
    }
}
