//! Interprets the functions of a checked module; see `check.rs` for the allowed constructs.

use super::{
    operations::{binary, converted, math, relational, unary},
    values::{Flat, Val},
};
use naga::{Block, Expression, Function, Handle, Literal, LocalVariable, Module, ScalarKind, Statement, SwitchValue};

/// Deepest nesting of calls: each takes stack space.
const MOST_DEPTH: u32 = 64;

/// An execution of a module: its variables and the remaining statements.
pub struct Machine<'a> {
    module: &'a Module,
    /// Private variables of the module.
    globals: Vec<Val>,
    statements: u32,
    /// Current call depth.
    depth: u32,
}

/// The evaluation exceeded its statements or call depth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Endless;

/// How a block exits.
enum Flow {
    Next,
    Break,
    Continue,
    Return(Option<Val>),
}

/// Target of a pointer.
struct Place {
    root: Root,
    path: Vec<usize>,
}

enum Root {
    Local(Handle<LocalVariable>),
    Global(usize),
}

/// An active call.
struct Frame<'f> {
    function: &'f Function,
    arguments: Vec<Val>,
    locals: Vec<Val>,
    /// Values of emitted expressions and of calls.
    values: Vec<Option<Val>>,
}

impl<'a> Machine<'a> {
    /// A machine with a limit of statements.
    pub fn new(module: &'a Module, statements: u32) -> Self {
        let mut machine = Self { module, globals: Vec::new(), statements, depth: 0 };
        for (_, variable) in module.global_variables.iter() {
            let zero = Val::zero(module, &module.types[variable.ty].inner);
            let value = variable.init.map_or(zero, |init| machine.constant(init));
            machine.globals.push(value);
        }
        machine
    }

    /// Value of a private variable.
    pub fn global(&self, variable: Handle<naga::GlobalVariable>) -> &Val {
        &self.globals[variable.index()]
    }

    /// Calls a function.
    pub fn call(&mut self, function: Handle<Function>, arguments: Vec<Val>) -> Result<Option<Val>, Endless> {
        if self.depth == MOST_DEPTH {
            return Err(Endless);
        }
        self.depth += 1;
        let module = self.module;
        let function = &module.functions[function];
        let mut frame =
            Frame { function, arguments, locals: Vec::new(), values: vec![None; function.expressions.len()] };
        for (_, local) in function.local_variables.iter() {
            let zero = Val::zero(module, &module.types[local.ty].inner);
            let value = local.init.map_or(zero, |init| self.value(&frame, init));
            frame.locals.push(value);
        }
        let flow = self.block(&mut frame, &function.body)?;
        self.depth -= 1;
        match flow {
            Flow::Return(value) => Ok(value),
            _ => Ok(None),
        }
    }

    fn block(&mut self, frame: &mut Frame, block: &Block) -> Result<Flow, Endless> {
        for statement in block.iter() {
            self.statements = self.statements.checked_sub(1).ok_or(Endless)?;
            match self.statement(frame, statement)? {
                Flow::Next => {}
                other => return Ok(other),
            }
        }
        Ok(Flow::Next)
    }

    fn statement(&mut self, frame: &mut Frame, statement: &Statement) -> Result<Flow, Endless> {
        match statement {
            Statement::Emit(range) => {
                for handle in range.clone() {
                    let value = self.evaluated(frame, handle);
                    frame.values[handle.index()] = Some(value);
                }
            }
            Statement::Block(block) => return self.block(frame, block),
            Statement::If { condition, accept, reject } => {
                let is_true = self.value(frame, *condition).flat().is_true();
                return self.block(frame, if is_true { accept } else { reject });
            }
            Statement::Switch { selector, cases } => {
                let selector = self.value(frame, *selector).flat().bits[0];
                return self.switch(frame, selector, cases);
            }
            Statement::Loop { body, continuing, break_if } => return self.repeat(frame, body, continuing, *break_if),
            Statement::Break => return Ok(Flow::Break),
            Statement::Continue => return Ok(Flow::Continue),
            Statement::Return { value } => return Ok(Flow::Return(value.map(|value| self.value(frame, value)))),
            Statement::Store { pointer, value } => {
                let value = self.value(frame, *value);
                let Place { root, path } = self.place(frame, *pointer);
                match root {
                    Root::Local(local) => frame.locals[local.index()].store(&path, value),
                    Root::Global(index) => self.globals[index].store(&path, value),
                }
            }
            Statement::Call { function, arguments, result } => {
                let arguments = arguments.iter().map(|&argument| self.value(frame, argument)).collect();
                let value = self.call(*function, arguments)?;
                if let (Some(result), Some(value)) = (result, value) {
                    frame.values[result.index()] = Some(value);
                }
            }
            // Reading the module rejects everything else.
            _ => {}
        }
        Ok(Flow::Next)
    }

    fn switch(&mut self, frame: &mut Frame, selector: u32, cases: &[naga::SwitchCase]) -> Result<Flow, Endless> {
        let is_chosen = |case: &naga::SwitchCase| match case.value {
            SwitchValue::I32(x) => x as u32 == selector,
            SwitchValue::U32(x) => x == selector,
            SwitchValue::Default => false,
        };
        let default = || cases.iter().position(|case| case.value == SwitchValue::Default);
        let Some(first) = cases.iter().position(is_chosen).or_else(default) else { return Ok(Flow::Next) };
        for case in &cases[first..] {
            match self.block(frame, &case.body)? {
                Flow::Next if case.fall_through => {}
                Flow::Next | Flow::Break => return Ok(Flow::Next),
                other => return Ok(other),
            }
        }
        Ok(Flow::Next)
    }

    fn repeat(
        &mut self,
        frame: &mut Frame,
        body: &Block,
        continuing: &Block,
        break_if: Option<Handle<Expression>>,
    ) -> Result<Flow, Endless> {
        loop {
            self.statements = self.statements.checked_sub(1).ok_or(Endless)?;
            match self.block(frame, body)? {
                Flow::Next | Flow::Continue => {}
                Flow::Break => return Ok(Flow::Next),
                returned => return Ok(returned),
            }
            self.block(frame, continuing)?;
            if break_if.is_some_and(|condition| self.value(frame, condition).flat().is_true()) {
                return Ok(Flow::Next);
            }
        }
    }

    /// The value of an expression.
    fn value(&self, frame: &Frame, handle: Handle<Expression>) -> Val {
        frame.values[handle.index()].clone().unwrap_or_else(|| self.evaluated(frame, handle))
    }

    fn flat(&self, frame: &Frame, handle: Handle<Expression>) -> Flat {
        match &frame.values[handle.index()] {
            Some(value) => value.flat(),
            None => self.evaluated(frame, handle).flat(),
        }
    }

    fn evaluated(&self, frame: &Frame, handle: Handle<Expression>) -> Val {
        match &frame.function.expressions[handle] {
            &Expression::FunctionArgument(index) => frame.arguments[index as usize].clone(),
            &Expression::Load { pointer } => {
                let Place { root, path } = self.place(frame, pointer);
                let value = match root {
                    Root::Local(local) => &frame.locals[local.index()],
                    Root::Global(index) => &self.globals[index],
                };
                value.load(&path)
            }
            expression => {
                self.computed(expression, &|handle| self.value(frame, handle), &|handle| self.flat(frame, handle))
            }
        }
    }

    /// The value of a constant expression of the module.
    fn constant(&self, handle: Handle<Expression>) -> Val {
        self.computed(&self.module.global_expressions[handle], &|handle| self.constant(handle), &|handle| {
            self.constant(handle).flat()
        })
    }

    /// Evaluates an expression; `value` gives its operands.
    fn computed(
        &self,
        expression: &Expression,
        value: &dyn Fn(Handle<Expression>) -> Val,
        flat: &dyn Fn(Handle<Expression>) -> Flat,
    ) -> Val {
        match *expression {
            Expression::Literal(literal) => Val::Flat(literal_value(literal)),
            Expression::Constant(constant) => self.constant(self.module.constants[constant].init),
            Expression::ZeroValue(ty) => Val::zero(self.module, &self.module.types[ty].inner),
            Expression::Compose { ty, ref components } => self.composed(ty, components.iter().map(|&c| value(c))),
            Expression::Access { base, index } => value(base).part(flat(index).index()),
            Expression::AccessIndex { base, index } => value(base).part(index as usize),
            Expression::Splat { size, value: scalar } => {
                Val::Flat(Flat { len: size as u8, bits: [flat(scalar).bits[0]; 4], ..flat(scalar) })
            }
            Expression::Swizzle { size, vector, pattern } => {
                let vector = flat(vector);
                let bits = pattern.map(|component| vector.bits[component as usize]);
                Val::Flat(Flat { kind: vector.kind, len: size as u8, bits })
            }
            Expression::Unary { op, expr } => unary(op, &value(expr)),
            Expression::Binary { op, left, right } => binary(op, &value(left), &value(right)),
            Expression::Select { condition, accept, reject } => {
                let condition = flat(condition);
                if condition.len == 1 {
                    return value(if condition.is_true() { accept } else { reject });
                }
                let (accept, reject) = (flat(accept), flat(reject));
                let bits = std::array::from_fn(|i| if condition.bits[i] != 0 { accept.at(i) } else { reject.at(i) });
                Val::Flat(Flat { bits, ..accept })
            }
            Expression::Relational { fun, argument } => Val::Flat(relational(fun, &flat(argument))),
            Expression::Math { fun, arg, arg1, arg2, .. } => {
                let first = value(arg);
                let [second, third] = [arg1, arg2].map(|arg| arg.map(value));
                math(fun, &first, [second.as_ref().unwrap_or(&first), third.as_ref().unwrap_or(&first)])
            }
            Expression::As { expr, kind, convert } => converted(&value(expr), kind, convert.is_none()),
            // Reading the module rejects everything else.
            _ => Val::Flat(Flat::float(f32::NAN)),
        }
    }

    fn composed(&self, ty: Handle<naga::Type>, components: impl Iterator<Item = Val>) -> Val {
        let naga::TypeInner::Vector { scalar, .. } = self.module.types[ty].inner else {
            return Val::Many(components.collect());
        };
        let mut vector = Flat { kind: scalar.kind, len: 0, bits: [0; 4] };
        for component in components.map(|component| component.flat()) {
            for i in 0..component.len as usize {
                vector.bits[vector.len as usize] = component.bits[i];
                vector.len += 1;
            }
        }
        Val::Flat(vector)
    }

    fn place(&self, frame: &Frame, pointer: Handle<Expression>) -> Place {
        match frame.function.expressions[pointer] {
            Expression::LocalVariable(local) => Place { root: Root::Local(local), path: Vec::new() },
            Expression::AccessIndex { base, index } => self.inside(frame, base, index as usize),
            Expression::Access { base, index } => self.inside(frame, base, self.flat(frame, index).index()),
            Expression::GlobalVariable(global) => Place { root: Root::Global(global.index()), path: Vec::new() },
            // Reading the module checks pointers.
            ref other => unreachable!("no pointer: {other:?}"),
        }
    }

    fn inside(&self, frame: &Frame, base: Handle<Expression>, index: usize) -> Place {
        let mut place = self.place(frame, base);
        place.path.push(index);
        place
    }
}

fn literal_value(literal: Literal) -> Flat {
    match literal {
        Literal::F32(x) => Flat::float(x),
        Literal::U32(x) => Flat::scalar(ScalarKind::Uint, x),
        Literal::I32(x) => Flat::scalar(ScalarKind::Sint, x as u32),
        Literal::Bool(is) => Flat::truth(is),
        // Reading the module rejects everything else.
        _ => Flat::float(f32::NAN),
    }
}
