//! Makes a module terminate: iterations and calls are counted, and past a limit loops break and functions return zero.
//! The counter is in the module itself, so interpreter and shaders behave the same.

use naga::{
    AddressSpace, BinaryOperator, Block, Expression, Function, GlobalVariable, Handle, Literal, MemoryDecorations,
    Module, Range, Scalar, Span, Statement, Type, TypeInner,
};

/// Largest number of iterations and calls in one evaluation.
pub const MOST_STEPS: u32 = 4096;
/// Name of the counter.
pub const STEPS: &str = "steps_taken";

/// Adds counting to all functions; `root` resets the counter.
pub fn bound(module: &mut Module, root: Handle<Function>) -> Handle<GlobalVariable> {
    let ty = Type { name: None, inner: TypeInner::Scalar(Scalar::U32) };
    let ty = module.types.insert(ty, Span::UNDEFINED);
    let counter = GlobalVariable {
        name: Some(STEPS.into()),
        space: AddressSpace::Private,
        binding: None,
        ty,
        init: None,
        memory_decorations: MemoryDecorations::empty(),
    };
    let counter = module.global_variables.append(counter, Span::UNDEFINED);
    for (handle, function) in module.functions.iter_mut() {
        let mut body = std::mem::take(&mut function.body);
        bound_loops(&mut body, function, counter);
        let mut head = match handle == root {
            true => reset(function, counter),
            false => {
                let result = function.result.as_ref().map(|result| result.ty);
                let value = result.map(|ty| function.expressions.append(Expression::ZeroValue(ty), Span::UNDEFINED));
                counted(function, counter, Statement::Return { value })
            }
        };
        head.append(&mut body);
        function.body = head;
    }
    counter
}

fn bound_loops(block: &mut Block, function: &mut Function, counter: Handle<GlobalVariable>) {
    for (statement, _) in block.span_iter_mut() {
        match statement {
            Statement::Block(inner) => bound_loops(inner, function, counter),
            Statement::If { accept, reject, .. } => {
                bound_loops(accept, function, counter);
                bound_loops(reject, function, counter);
            }
            Statement::Switch { cases, .. } => {
                cases.iter_mut().for_each(|case| bound_loops(&mut case.body, function, counter));
            }
            Statement::Loop { body, continuing, .. } => {
                bound_loops(body, function, counter);
                bound_loops(continuing, function, counter);
                body.splice(0..0, counted(function, counter, Statement::Break));
            }
            _ => {}
        }
    }
}

/// Increments the counter and executes `leave` past the limit.
fn counted(function: &mut Function, counter: Handle<GlobalVariable>, leave: Statement) -> Block {
    let mut add = |expression| function.expressions.append(expression, Span::UNDEFINED);
    let pointer = add(Expression::GlobalVariable(counter));
    let one = add(Expression::Literal(Literal::U32(1)));
    let limit = add(Expression::Literal(Literal::U32(MOST_STEPS)));
    let before = add(Expression::Load { pointer });
    let value = add(Expression::Binary { op: BinaryOperator::Add, left: before, right: one });
    let condition = add(Expression::Binary { op: BinaryOperator::Greater, left: value, right: limit });
    let leave = Block::from_vec(vec![leave]);
    Block::from_vec(vec![
        Statement::Emit(Range::new_from_bounds(before, condition)),
        Statement::Store { pointer, value },
        Statement::If { condition, accept: leave, reject: Block::new() },
    ])
}

fn reset(function: &mut Function, counter: Handle<GlobalVariable>) -> Block {
    let pointer = function.expressions.append(Expression::GlobalVariable(counter), Span::UNDEFINED);
    let value = function.expressions.append(Expression::Literal(Literal::U32(0)), Span::UNDEFINED);
    Block::from_vec(vec![Statement::Store { pointer, value }])
}

/// The module with `prefix` before all its names, to avoid clashes in a shader.
pub fn renamed(module: &Module, prefix: &str) -> Module {
    let mut module = module.clone();
    let with_prefix = |name: &mut Option<String>| {
        if let Some(name) = name {
            name.insert_str(0, prefix);
        }
    };
    module.functions.iter_mut().for_each(|(_, function)| with_prefix(&mut function.name));
    module.constants.iter_mut().for_each(|(_, constant)| with_prefix(&mut constant.name));
    module.global_variables.iter_mut().for_each(|(_, variable)| with_prefix(&mut variable.name));
    // Unnamed types are written out where they are used.
    let named = module.types.iter().filter(|(_, ty)| ty.name.is_some());
    let named: Vec<_> = named.map(|(handle, ty)| (handle, ty.clone())).collect();
    for (handle, mut ty) in named {
        with_prefix(&mut ty.name);
        module.types.replace(handle, ty);
    }
    module
}
