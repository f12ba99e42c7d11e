//! Checks of a module: a function `brdf` of the parameters and two directions, with its callees, of constructs that the
//! interpreter knows.

use super::{WrittenError, operations::is_known};
use naga::{
    ArraySize, Block, Expression, Function, Handle, Literal, Module, Scalar, ScalarKind, Span, Statement, TypeInner,
    VectorSize,
};

/// Name of the function.
pub const ROOT: &str = "brdf";
/// Required signature.
pub const SIGNATURE: &str = "fn brdf(p: Parameters, wi: vec3<f32>, wo: vec3<f32>) -> vec3<f32>";
/// Largest number of expressions in all functions, and of elements in an array.
const MOST_EXPRESSIONS: usize = 20_000;
const MOST_ELEMENTS: u32 = 1024;
/// Largest count of numbers in a value, and in all variables of a function: the interpreter copies them.
const MOST_NUMBERS: u64 = 4096;

/// Checks a module and finds its function.
///
/// # Errors
/// The first forbidden construct, with its line.
pub fn check(module: &Module, text: &str) -> Result<Handle<Function>, WrittenError> {
    let refused = |span: Span, what: &str| WrittenError::in_span(text, span, what.into());
    if let Some((handle, _)) = module.global_variables.iter().next() {
        let span = module.global_variables.get_span(handle);
        return Err(refused(span, "a BRDF has no variables outside its functions; use const, or a parameter"));
    }
    if let Some((handle, _)) = module.overrides.iter().next() {
        return Err(refused(module.overrides.get_span(handle), "a BRDF has no override; use const, or a parameter"));
    }
    if let Some(entry) = module.entry_points.first() {
        return Err(WrittenError::whole(format!("{} is an entry point; a BRDF has only functions", entry.name)));
    }
    let mut numbers = Vec::new();
    for (handle, ty) in module.types.iter() {
        let checked = check_type(&ty.inner).and_then(|()| checked_numbers(&ty.inner, &numbers));
        numbers.push(checked.map_err(|what| refused(module.types.get_span(handle), &what))?);
    }
    let count: usize = module.functions.iter().map(|(_, f)| f.expressions.len()).sum();
    if count > MOST_EXPRESSIONS {
        return Err(WrittenError::whole(format!(
            "it has {count} expressions, more than {MOST_EXPRESSIONS}; make it shorter"
        )));
    }
    for (_, function) in module.functions.iter() {
        let of_locals = function.local_variables.iter().map(|(_, local)| numbers[local.ty.index()]);
        if of_locals.sum::<u64>() > MOST_NUMBERS {
            let name = function.name.as_deref().unwrap_or_default();
            return Err(WrittenError::whole(format!(
                "the function {name} must have variables of at most {MOST_NUMBERS} numbers"
            )));
        }
        check_function(function, text)?;
    }
    let is_root = |function: &Function| function.name.as_deref() == Some(ROOT);
    let found = module.functions.iter().find(|(_, function)| is_root(function));
    let (root, function) =
        found.ok_or_else(|| WrittenError::whole(format!("it lacks the function \"{SIGNATURE}\"")))?;
    if !has_signature(module, function) {
        let span = module.functions.get_span(root);
        return Err(refused(span, &format!("the function must be declared \"{SIGNATURE}\"")));
    }
    Ok(root)
}

fn has_signature(module: &Module, function: &Function) -> bool {
    let is_direction = |ty: Handle<naga::Type>| {
        module.types[ty].inner == TypeInner::Vector { size: VectorSize::Tri, scalar: Scalar::F32 }
    };
    let [p, wi, wo] = &function.arguments[..] else { return false };
    module.types[p.ty].name.as_deref() == Some("Parameters")
        && is_direction(wi.ty)
        && is_direction(wo.ty)
        && function.result.as_ref().is_some_and(|result| is_direction(result.ty))
}

/// Count of numbers in a value; `before` holds the counts of its component types.
fn checked_numbers(ty: &TypeInner, before: &[u64]) -> Result<u64, String> {
    let numbers = match *ty {
        TypeInner::Vector { size, .. } => size as u64,
        TypeInner::Matrix { columns, rows, .. } => columns as u64 * rows as u64,
        TypeInner::Array { base, size: ArraySize::Constant(count), .. } => {
            before[base.index()] * u64::from(count.get())
        }
        TypeInner::Struct { ref members, .. } => members.iter().map(|member| before[member.ty.index()]).sum(),
        _ => 1,
    };
    if numbers > MOST_NUMBERS {
        return Err(format!("a value of a BRDF has at most {MOST_NUMBERS} numbers, this {numbers}"));
    }
    Ok(numbers)
}

fn check_type(ty: &TypeInner) -> Result<(), String> {
    let is_plain = |scalar: Scalar| match scalar.kind {
        ScalarKind::Float | ScalarKind::Sint | ScalarKind::Uint => scalar.width == 4,
        ScalarKind::Bool => true,
        _ => false,
    };
    match *ty {
        TypeInner::Scalar(scalar) | TypeInner::Vector { scalar, .. } | TypeInner::Matrix { scalar, .. } => {
            if is_plain(scalar) { Ok(()) } else { Err("numbers of a BRDF have 32 bits".into()) }
        }
        TypeInner::Array { size: ArraySize::Constant(count), .. } if count.get() <= MOST_ELEMENTS => Ok(()),
        TypeInner::Array { .. } => Err(format!("an array of a BRDF has a constant size of at most {MOST_ELEMENTS}")),
        TypeInner::Struct { .. } => Ok(()),
        _ => Err("a BRDF has only numbers, vectors, matrices, arrays and structures; pass no pointers".into()),
    }
}

fn check_function(function: &Function, text: &str) -> Result<(), WrittenError> {
    for (handle, expression) in function.expressions.iter() {
        check_expression(expression)
            .map_err(|what| WrittenError::in_span(text, function.expressions.get_span(handle), what.into()))?;
    }
    check_block(&function.body, text)
}

fn check_expression(expression: &Expression) -> Result<(), &'static str> {
    match *expression {
        Expression::Literal(Literal::F32(_) | Literal::I32(_) | Literal::U32(_) | Literal::Bool(_))
        | Expression::Constant(_)
        | Expression::ZeroValue(_)
        | Expression::Compose { .. }
        | Expression::Access { .. }
        | Expression::AccessIndex { .. }
        | Expression::Splat { .. }
        | Expression::Swizzle { .. }
        | Expression::FunctionArgument(_)
        | Expression::LocalVariable(_)
        | Expression::Load { .. }
        | Expression::Unary { .. }
        | Expression::Binary { .. }
        | Expression::Select { .. }
        | Expression::Relational { .. }
        | Expression::CallResult(_) => Ok(()),
        Expression::As { convert, .. } if convert.is_none_or(|bytes| bytes == 4 || bytes == 1) => Ok(()),
        Expression::Math { fun, .. } if is_known(fun) => Ok(()),
        Expression::Literal(Literal::AbstractFloat(_) | Literal::AbstractInt(_)) => {
            Err("the type of this number is left open; write it as 2.0f, 2i or 2u")
        }
        Expression::Math { .. } => Err("this function is not interpreted, so the CPU could not show it"),
        Expression::Derivative { .. } => Err("a BRDF has no derivatives: it knows one direction at a time"),
        _ => Err("this construct is not interpreted, so the CPU could not show it"),
    }
}

fn check_block(block: &Block, text: &str) -> Result<(), WrittenError> {
    for (statement, span) in block.span_iter() {
        match statement {
            Statement::Emit(_)
            | Statement::Break
            | Statement::Continue
            | Statement::Return { .. }
            | Statement::Store { .. }
            | Statement::Call { .. } => {}
            Statement::Block(inner) => check_block(inner, text)?,
            Statement::If { accept, reject, .. } => {
                check_block(accept, text)?;
                check_block(reject, text)?;
            }
            Statement::Switch { cases, .. } => cases.iter().try_for_each(|case| check_block(&case.body, text))?,
            Statement::Loop { body, continuing, .. } => {
                check_block(body, text)?;
                check_block(continuing, text)?;
            }
            _ => {
                return Err(WrittenError::in_span(
                    text,
                    *span,
                    "a BRDF only computes; this statement does more".into(),
                ));
            }
        }
    }
    Ok(())
}
