//! Finds in a file what each of its mutants changes.

use crate::{Mutant, Position, Switch};
use proc_macro2::{LineColumn, Span};
use std::ops::Range;
use syn::spanned::Spanned;
use syn::visit::{self, Visit};

/// The switches of all mutants of a file.
pub(crate) fn of(text: &str, mutants: &[&Mutant]) -> Vec<Switch> {
    let file = syn::parse_file(text).expect("a file that the compiler reads");
    let found = mutants.iter().map(|_| Switch::Not("not found")).collect();
    let mut finder = Finder { text, mutants, found, constant: 0 };
    finder.visit_file(&file);
    finder.found
}

/// Goes through a file.
struct Finder<'a> {
    text: &'a str,
    mutants: &'a [&'a Mutant],
    found: Vec<Switch>,
    /// In how many places that the compiler evaluates this one is: no switch can be read there.
    constant: usize,
}

fn position(at: LineColumn) -> Position {
    Position { line: at.line, column: at.column + 1 }
}

fn is_constant(signature: &syn::Signature) -> bool {
    signature.constness.is_some()
}

fn is_opaque(output: &syn::ReturnType) -> bool {
    matches!(output, syn::ReturnType::Type(_, what) if matches!(**what, syn::Type::ImplTrait(_)))
}

impl Finder<'_> {
    /// Gives each mutant of this genre that starts at `span` its switch.
    fn find(&mut self, genre: &str, span: Span, switch: impl Fn(&Self, &Mutant) -> Switch) {
        let start = position(span.start());
        for (number, mutant) in self.mutants.iter().enumerate() {
            if mutant.genre == genre && mutant.span.start == start {
                self.found[number] = match self.constant {
                    0 => switch(self, mutant),
                    _ => Switch::Not("evaluated by the compiler"),
                };
            }
        }
    }

    /// Within what the compiler evaluates, if it is.
    fn within(&mut self, constant: bool, visit: impl FnOnce(&mut Self)) {
        self.constant += usize::from(constant);
        visit(self);
        self.constant -= usize::from(constant);
    }

    /// The expression `whole`, with `replacement` in place of `part` of it.
    fn instead(&self, whole: Span, part: Range<usize>, replacement: &str) -> Switch {
        let Range { start, end } = whole.byte_range();
        let text = [&self.text[start..part.start], replacement, &self.text[part.end..end]].concat();
        Switch::Instead { start, end, text }
    }

    /// Another value of the function: returned at the start of its body.
    fn body(&mut self, block: &syn::Block, output: &syn::ReturnType) {
        let Some(first) = block.stmts.first() else { return };
        let at = block.brace_token.span.open().byte_range().end;
        let opaque = is_opaque(output);
        self.find("FnValue", first.span(), |_, mutant| match opaque {
            true => Switch::Not("another type in place of an opaque one"),
            false => Switch::Insert { at, text: format!(" if FAULT {{ return {}; }} ", mutant.replacement) },
        });
    }
}

/// Visits of what stands where the compiler evaluates it.
macro_rules! evaluated_by_the_compiler {
    ($($visit:ident: $what:ident,)*) => {
        $(fn $visit(&mut self, item: &'a syn::$what) {
            self.within(true, |inner| visit::$visit(inner, item));
        })*
    };
}

impl<'a> Visit<'a> for Finder<'_> {
    evaluated_by_the_compiler! {
        visit_item_const: ItemConst,
        visit_impl_item_const: ImplItemConst,
        visit_trait_item_const: TraitItemConst,
        visit_item_static: ItemStatic,
        visit_expr_const: ExprConst,
        visit_type_array: TypeArray,
        visit_generic_argument: GenericArgument,
        visit_variant: Variant,
    }

    fn visit_expr_repeat(&mut self, repeat: &'a syn::ExprRepeat) {
        self.visit_expr(&repeat.expr);
        self.within(true, |inner| inner.visit_expr(&repeat.len));
    }

    fn visit_item_fn(&mut self, item: &'a syn::ItemFn) {
        self.within(is_constant(&item.sig), |inner| {
            inner.body(&item.block, &item.sig.output);
            visit::visit_item_fn(inner, item);
        });
    }

    fn visit_impl_item_fn(&mut self, item: &'a syn::ImplItemFn) {
        self.within(is_constant(&item.sig), |inner| {
            inner.body(&item.block, &item.sig.output);
            visit::visit_impl_item_fn(inner, item);
        });
    }

    fn visit_trait_item_fn(&mut self, item: &'a syn::TraitItemFn) {
        if let Some(block) = &item.default {
            self.body(block, &item.sig.output);
        }
        visit::visit_trait_item_fn(self, item);
    }

    fn visit_expr_binary(&mut self, binary: &'a syn::ExprBinary) {
        let operator = binary.op.span();
        self.find("BinaryOperator", operator, |inner, mutant| {
            inner.instead(binary.span(), operator.byte_range(), &mutant.replacement)
        });
        visit::visit_expr_binary(self, binary);
    }

    fn visit_expr_unary(&mut self, unary: &'a syn::ExprUnary) {
        let operator = unary.op.span();
        self.find("UnaryOperator", operator, |inner, _| {
            inner.instead(unary.span(), operator.byte_range(), "")
        });
        visit::visit_expr_unary(self, unary);
    }

    fn visit_arm(&mut self, arm: &'a syn::Arm) {
        match &arm.guard {
            Some((_, guard)) => {
                let whole = guard.span().byte_range();
                self.find("MatchArmGuard", guard.span(), |inner, mutant| {
                    inner.instead(guard.span(), whole.clone(), &mutant.replacement)
                });
                self.find("MatchArm", arm.span(), |inner, _| {
                    inner.instead(guard.span(), whole.clone(), "false")
                });
            }
            None => {
                let at = arm.pat.span().byte_range().end;
                self.find("MatchArm", arm.span(), |_, _| Switch::Insert {
                    at,
                    text: " if !FAULT".to_owned(),
                });
            }
        }
        visit::visit_arm(self, arm);
    }

    fn visit_expr_struct(&mut self, whole: &'a syn::ExprStruct) {
        for pair in whole.fields.pairs() {
            let (field, comma) = (pair.value(), pair.punct());
            let start = field.span().byte_range();
            let end = comma.map_or(start.end, |comma| comma.span().byte_range().end);
            self.find("StructField", field.span(), |inner, _| {
                inner.instead(whole.span(), start.start..end, "")
            });
        }
        visit::visit_expr_struct(self, whole);
    }
}
