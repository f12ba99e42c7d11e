//! Numbers with their units, for people.

/// A whole number in groups of three digits.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::with_capacity(digits.len() * 4 / 3);
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// Bytes in kB, MB or GB of powers of ten.
pub fn bytes(count: u64) -> String {
    let count = count as f64;
    match count {
        c if c < 1e6 => format!("{:.1} kB", c / 1e3),
        c if c < 1e9 => format!("{:.1} MB", c / 1e6),
        c => format!("{:.2} GB", c / 1e9),
    }
}

/// A duration from tenths of a second to hours, in readable precision.
pub fn duration(secs: f64) -> String {
    let whole = secs.max(0.0).round() as u64;
    match whole {
        _ if secs < 9.95 => format!("{:.1} s", secs.max(0.0)),
        0..60 => format!("{whole} s"),
        60..3600 => format!("{} min {:02} s", whole / 60, whole % 60),
        _ => format!("{} h {:02} min", whole / 3600, whole % 3600 / 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_grouped_and_rounded() {
        assert_eq!([7, 999, 32_768, 1_234_567].map(grouped), ["7", "999", "32,768", "1,234,567"]);
        assert_eq!([900, 9_250_000, 3_400_000_000].map(bytes), ["0.9 kB", "9.2 MB", "3.40 GB"]);
        assert_eq!([0.04, 9.97, 75.4, 7260.0].map(duration), ["0.0 s", "10 s", "1 min 15 s", "2 h 01 min"]);
    }
}
