//! Errors of the TOML parser, in words for people who write scenes.

use super::error::{Fault, quote};

/// Rewords a syntax error of the TOML parser for people who write scenes.
pub(super) fn syntax_fault(text: &str, error: &toml::de::Error) -> Fault {
    let span = error.span().unwrap_or_default();
    let found = text.get(span.clone()).unwrap_or_default();
    let (problem, expected) =
        error.message().split_once(", expected ").unwrap_or((error.message(), "nothing"));
    let message = match problem {
        "duplicate key" if found == "sphere" => "head every sphere with [[sphere]]".into(),
        "duplicate key" => format!("key {} is given twice; keep one", quote(found)),
        "cannot recurse further; max recursion depth met" | "recursion limit" => {
            "tables or arrays are nested too deeply; a scene needs three levels".into()
        }
        "string values must be quoted" if found.is_empty() => "a value is missing here".into(),
        "string values must be quoted" | "invalid boolean" => {
            format!(
                "{} is no value; write a number as 1.5, a string as \"...\", an array as [1, 2, 3]",
                quote(found)
            )
        }
        "missing comma between array elements" => {
            "an array must go on with a comma or end with ] here".into()
        }
        "invalid basic string" if expected == "`\"`" => {
            "a string must end with \" on the line it begins on".into()
        }
        _ if expected == "nothing" => format!("this is not TOML: {problem}"),
        _ => format!("this is not TOML: {problem}; expected {expected}"),
    };
    Fault::new(span.start, message)
}
