//! Expressions such as `2*10`, `3,5` and `3 cm + 1/4 in`.

/// Units by their names: what they measure, and how many of its first they are.
const UNITS: [(&str, Kind, f64); 14] = [
    ("m", Kind::Length, 1.0),
    ("mm", Kind::Length, 1e-3),
    ("cm", Kind::Length, 1e-2),
    ("km", Kind::Length, 1e3),
    ("in", Kind::Length, 0.0254),
    ("ft", Kind::Length, 0.3048),
    ("°", Kind::Angle, 1.0),
    ("deg", Kind::Angle, 1.0),
    ("rad", Kind::Angle, 180.0 / std::f64::consts::PI),
    ("turn", Kind::Angle, 360.0),
    ("%", Kind::Share, 0.01),
    ("EV", Kind::Stops, 1.0),
    ("fps", Kind::Rate, 1.0),
    ("spp", Kind::Samples, 1.0),
];

/// Longest text that is read, so that nothing nests too deep.
const LONGEST: usize = 200;

/// What a unit measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Length,
    Angle,
    Share,
    Stops,
    Rate,
    Samples,
}

/// The value of a text in a unit, as " mm". Numbers may have units of the same kind, a point or a comma; `+ - * /` and parentheses
/// are computed.
///
/// # Errors
/// Why it is no number, in words.
pub fn value_of(text: &str, unit: &str) -> Result<f64, String> {
    if text.len() > LONGEST {
        return Err("the text is too long for a number".into());
    }
    let own = unit_called(unit.trim());
    let mut reader = Reader { rest: text, own };
    let value = reader.sum()?;
    reader.skip();
    match reader.rest.chars().next() {
        Some(c) => Err(format!("\"{c}\" is no part of a number")),
        None if value.is_finite() => Ok(value),
        None => Err("the number is too large".into()),
    }
}

fn unit_called(name: &str) -> Option<(Kind, f64)> {
    UNITS.iter().find(|unit| unit.0 == name).map(|&(_, kind, factor)| (kind, factor))
}

struct Reader<'a> {
    rest: &'a str,
    own: Option<(Kind, f64)>,
}

impl Reader<'_> {
    fn skip(&mut self) {
        self.rest = self.rest.trim_start();
    }

    /// Takes the first of some signs that comes next.
    fn takes(&mut self, signs: &[char]) -> Option<char> {
        self.skip();
        let sign = self.rest.chars().next().filter(|next| signs.contains(next))?;
        self.rest = &self.rest[sign.len_utf8()..];
        Some(sign)
    }

    fn sum(&mut self) -> Result<f64, String> {
        let mut sum = self.product()?;
        while let Some(sign) = self.takes(&['+', '-', '\u{2212}']) {
            let next = self.product()?;
            sum += if sign == '+' { next } else { -next };
        }
        Ok(sum)
    }

    fn product(&mut self) -> Result<f64, String> {
        let mut product = self.factor()?;
        while let Some(sign) = self.takes(&['*', '/', '×', '÷']) {
            let next = self.factor()?;
            if matches!(sign, '*' | '×') {
                product *= next;
            } else if next == 0.0 {
                return Err("nothing can be divided by zero".into());
            } else {
                product /= next;
            }
        }
        Ok(product)
    }

    /// A number, or an expression in parentheses, after any signs.
    fn factor(&mut self) -> Result<f64, String> {
        match self.takes(&['+', '-', '\u{2212}', '(']) {
            Some('+') => self.factor(),
            Some('(') => self.parenthesized(),
            Some(_) => Ok(-self.factor()?),
            None => self.number(),
        }
    }

    fn parenthesized(&mut self) -> Result<f64, String> {
        let value = self.sum()?;
        self.takes(&[')']).map(|_| value).ok_or_else(|| "a parenthesis is not closed".into())
    }

    fn number(&mut self) -> Result<f64, String> {
        let is_part = |at: usize, c: char| {
            let before = self.rest[..at].chars().next_back();
            let is_exponent = matches!(c, 'e' | 'E') && before.is_some_and(|before| before.is_ascii_digit());
            let is_its_sign = matches!(c, '+' | '-') && matches!(before, Some('e' | 'E'));
            c.is_ascii_digit() || matches!(c, '.' | ',') || is_exponent || is_its_sign
        };
        let end = self.rest.char_indices().find(|&(at, c)| !is_part(at, c));
        let (digits, rest) = self.rest.split_at(end.map_or(self.rest.len(), |(end, _)| end));
        if digits.matches(['.', ',']).count() > 1 {
            return Err(format!("\"{digits}\" has more than one point or comma"));
        }
        let number: f64 = digits.replace(',', ".").parse().map_err(|_| match digits {
            "" => "a number is missing".to_owned(),
            _ => format!("\"{digits}\" is no number"),
        })?;
        self.rest = rest;
        Ok(number * self.unit()?)
    }

    /// How many of the own unit the unit is that follows a number, if any.
    fn unit(&mut self) -> Result<f64, String> {
        self.skip();
        let is_name = |c: char| c.is_alphabetic() || matches!(c, '°' | '%');
        let end = self.rest.find(|c| !is_name(c)).unwrap_or(self.rest.len());
        let (name, rest) = self.rest.split_at(end);
        if name.is_empty() {
            return Ok(1.0);
        }
        let (kind, factor) = unit_called(name).ok_or_else(|| format!("\"{name}\" is no unit that is known here"))?;
        let (own_kind, own) = match self.own {
            Some(own) => own,
            // Shares are written as numbers or in percent.
            None if kind == Kind::Share => (Kind::Share, 1.0),
            None => return Err(format!("this number has no unit, and is not in \"{name}\"")),
        };
        if kind != own_kind {
            return Err(format!("this number is not in \"{name}\""));
        }
        self.rest = rest;
        Ok(factor / own)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn expressions_commas_and_units_are_computed() {
        for (text, unit, expected) in [
            ("2*10", "", 20.0),
            ("3,5", "", 3.5),
            (" -(1 + 2) * 3 / 4 ", "", -2.25),
            ("1e-3", "", 1e-3),
            ("2E2", "", 200.0),
            ("1-2-3", "", -4.0),
            ("8/2/2", "", 2.0),
            ("--2", "", 2.0),
            ("\u{2212}4", "", -4.0),
            ("3 cm", " m", 0.03),
            ("1in + 1 mm", " mm", 26.4),
            ("2", " mm", 2.0),
            ("0.5 turn", "°", 180.0),
            ("3.14159265358979 rad", "°", 180.0),
            ("50 %", "", 0.5),
            ("1.5 EV", " EV", 1.5),
            (".5", "", 0.5),
        ] {
            let found = value_of(text, unit).unwrap();
            assert!((found - expected).abs() < 1e-9 * expected.abs().max(1.0), "{text}: {found}");
        }
    }

    #[test]
    fn what_is_no_number_is_refused_with_the_reason() {
        for (text, unit, reason) in [
            ("1/0", "", "divided by zero"),
            ("1e400", "", "too large"),
            ("1e300*1e300", "", "too large"),
            ("", "", "missing"),
            ("2*", "", "missing"),
            ("(1", "", "not closed"),
            ("1)", "", "\")\" is no part"),
            ("1,000.5", "", "more than one"),
            ("3 kg", " m", "no unit"),
            ("3 cm", "", "has no unit"),
            ("3 cm", "°", "not in \"cm\""),
            ("1e", "", "is no number"),
            ("red", "", "missing"),
            ("2 3", "", "\"3\" is no part"),
        ] {
            let told = value_of(text, unit).unwrap_err();
            assert!(told.contains(reason), "{text}: {told}");
        }
        for hostile in ["(".repeat(100_000), "-".repeat(100_000), "1+".repeat(100_000)] {
            assert!(value_of(&hostile, "").is_err());
        }
    }
}
