//! The interpreter against the same functions in Rust, and invalid texts.

use super::*;
use crate::{
    brdf::{BrdfModel, Parameters, Value},
    sphere::cosine_direction,
};

/// A text with one parameter and this function.
fn with(function: &str) -> String {
    format!("// @parameter x | X | number | 0.5 | 0..1 | m | What it is.\n{function}\n")
}

/// A text with this body of the function.
fn body(body: &str) -> String {
    with(&format!("fn brdf(p: Parameters, wi: vec3<f32>, wo: vec3<f32>) -> vec3<f32> {{ {body} }}"))
}

fn refused(text: &str) -> String {
    Written::new(text).map(|_| ()).unwrap_err().to_string()
}

fn value(text: &str, wi: Vec3, wo: Vec3) -> Vec3 {
    let written = Written::new(text).unwrap_or_else(|error| panic!("{error}\n{text}"));
    let values = Values::of(written.parameters(), &Parameters::default());
    written.value(&written.arguments(&values), wi, wo).unwrap()
}

#[test]
fn gloss_has_the_values_that_rust_computes() {
    let written = Written::new(include_str!("../../../../data/brdfs/gloss.wgsl")).unwrap();
    assert!(written.remarks().is_empty(), "{:?}", written.remarks());
    let mut random = fastrand::Rng::with_seed(5);
    let mut differ = 0;
    for _ in 0..200 {
        let [wi, wo] = [(); 2].map(|()| cosine_direction(random.f32(), random.f32()));
        let (gloss, exponent) = (random.f32(), 1.0 + 60.0 * random.f32());
        let told = Parameters::default().with("gloss", gloss).with("exponent", exponent);
        let values = Values::of(written.parameters(), &told.with("base_color", Vec3::new(0.1, 0.2, 0.3)));
        let found = written.value(&written.arguments(&values), wi, wo).unwrap();
        let highlight = |exponent: f32| {
            let cosine = Vec3::new(-wo.x, -wo.y, wo.z).dot(wi).max(0.0);
            gloss * (exponent + 2.0) / std::f32::consts::TAU * cosine.powf(exponent)
        };
        let diffuse = Vec3::new(0.1, 0.2, 0.3) * ((1.0 - gloss) / std::f32::consts::PI);
        let expected = diffuse + highlight(exponent);
        assert!((found - expected).length() <= 1e-5 * expected.length(), "{found}, not {expected}");
        let other = diffuse + highlight(1.2 * exponent + 1.0);
        differ += usize::from((found - other).length() > 1e-5 * other.length());
    }
    assert!(differ > 50, "negative control: {differ} of 200");
}

/// Each body gives the expected number in all three components.
#[test]
fn statements_and_functions_do_what_wgsl_says() {
    let wi = Vec3::new(0.48, 0.0, 0.877_268_5);
    for (text, expected) in [
        (
            "var s = 0.0; for (var i = 0; i < 10; i++) { if i == 3 { continue; } if i == 6 { break; } s += f32(i); } return vec3(s);",
            12.0,
        ),
        ("var s = 0u; var i = 0u; while i < 5u { s = s * 3u + i; i++; } return vec3(f32(s));", 58.0),
        ("var s = 1; loop { s *= 2; if s > 20 { break; } continuing { s += 1; } } return vec3(f32(s));", 30.0),
        (
            "switch i32(p.x * 4.0) { case 1: { return vec3(1.0); } case 2, 3: { return vec3(7.0); } default: { return vec3(2.0); } }",
            7.0,
        ),
        (
            "let m = mat2x2<f32>(1.0, 2.0, 3.0, 4.0); let v = m * vec2(5.0, 6.0); let w = vec2(5.0, 6.0) * m; return vec3(v.x + 100.0 * v.y + w.x);",
            3_440.0,
        ),
        (
            "let m = transpose(mat3x3<f32>(1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0)); return vec3(-determinant(m) + m[0].z);",
            10.0,
        ),
        ("var a = array<f32, 4>(1.0, 2.0, 3.0, 4.0); a[i32(p.x * 4.0)] = 9.0; return vec3(a[2] + a[1]);", 11.0),
        ("var v = vec3(1.0, 2.0, 3.0); v.y = 5.0; v[2] += 1.0; let w = v.zyx; return vec3(w.x * 10.0 + w.y);", 45.0),
        (
            "let b = vec3(1.0, 2.0, 3.0) > vec3(2.0, 1.0, 1.0); return select(vec3(8.0), vec3(3.0), !any(b) || !all(b)) ;",
            3.0,
        ),
        ("return vec3(dot(vec3(1.0, 2.0, 3.0), cross(vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0))));", 3.0),
        (
            "let k = i32(p.x * 4.0); let u = u32(k); return vec3(f32(dot(vec3(1i, k, 3i), vec3(-1i, 4i, 5i))) + f32(dot(vec2(u, 3u), vec2(4u, 5u))));",
            45.0,
        ),
        ("let u = u32(p.x * 4.0); return vec3(f32(dot(vec2(0x80000000u, u), vec2(u, 3u)) & 0xffffu));", 6.0),
        (
            "return vec3(clamp(7.5, 1.0, 3.0) + mix(2.0, 4.0, 0.5 * p.x) + smoothstep(0.0, 2.0, 2.0 * p.x) + step(1.0, 2.0) + fract(2.25));",
            7.25,
        ),
        (
            "return vec3(f32((7 / 2) + (7 % 4) + (1 << 3u)) + f32(0xffu & 0x1fu) + round(2.5) + sign(-3.0) * -1.0);",
            48.0,
        ),
        (
            "return vec3(length(refract(vec3(0.0, 0.0, -1.0), vec3(0.0, 0.0, 1.0), 0.7)) + distance(vec3(1.0), vec3(1.0, 1.0, 3.0)));",
            3.0,
        ),
        ("return vec3(exp2(3.0) + pow(2.0, 4.0) + sqrt(9.0) + log2(8.0) + abs(-1.0) + max(min(4.0, 2.0), 1.0));", 33.0),
    ] {
        let found = value(&body(text), wi, wi);
        assert!((found - expected).length() < 1e-4 * expected, "{found}, not {expected}: {text}");
        assert!((found - 1.01 * expected).length() > 1e-4 * expected, "negative control");
    }
    let helper = "struct Two { a: f32, b: vec2<f32> }\nconst K = 2.0;\nfn twice(t: Two) -> f32 { return K * (t.a + t.b.y); }\n\
                  fn brdf(p: Parameters, wi: vec3<f32>, wo: vec3<f32>) -> vec3<f32> { var t: Two; t.a = 1.0; t.b.y = 3.0; return vec3(twice(t)); }";
    assert_eq!(value(&with(helper), wi, wi), Vec3::splat(8.0));
}

#[test]
fn what_is_wrong_is_told_with_its_line() {
    let told =
        refused(&with("\nfn brdf(p: Parameters, wi: vec3<f32>, wo: vec3<f32>) -> vec3<f32> {\n    return vec3(q);\n}"));
    assert!(told.starts_with("line 4: ") && told.contains("`return vec3(q);`"), "{told}");
    let told = refused(&body("return vec2(1.0);"));
    assert!(told.starts_with("line 2: "), "{told}");
    assert!(refused(&with("fn other() {}")).contains("it lacks the function \"fn brdf("));
    let told = refused(&with("fn brdf(wi: vec3<f32>, wo: vec3<f32>) -> vec3<f32> { return wi; }"));
    assert!(told.starts_with("line 2: the function must be declared"), "{told}");
    let told = refused(&with("@group(0) @binding(0) var<uniform> u: f32;"));
    assert!(told.starts_with("line 2: a BRDF has no variables outside"), "{told}");
    let told = refused(
        &body("var x = 1.0; let y = &x; return vec3(other(y));")
            .replace("fn brdf", "fn other(x: ptr<function, f32>) -> f32 { return *x; }\nfn brdf"),
    );
    assert!(told.contains("pass no pointers"), "{told}");
    let told = refused(&body("return vec3(f32(countOneBits(u32(wi.x))));"));
    assert!(told.starts_with("line 2: this function is not interpreted"), "{told}");
    let told = refused(&body("return vec3(dpdx(wi.x));"));
    assert!(told.starts_with("line 2: "), "{told}");
    let told = refused(&body("var a: array<array<f32, 1024>, 1024>; a[0][0] = 0.1; return vec3(a[0][0]);"));
    assert!(told.contains("at most 4096 numbers"), "{told}");
    assert!(Written::new(&body("var a: array<array<f32, 4>, 4>; a[0][0] = 0.1; return vec3(a[0][0]);")).is_ok());
    let many: String = (0..5).map(|i| format!("var a{i}: array<f32, 1024>; a{i}[0] = 0.1; ")).collect();
    let told = refused(&body(&(many + "return vec3(a0[0] + a1[0] + a2[0] + a3[0] + a4[0]);")));
    assert!(told.contains("variables of at most 4096 numbers"), "{told}");
    assert!(refused("fn brdf() {}").contains("it declares no parameter"));
}

#[test]
fn parameters_that_cannot_be_are_told_with_their_line() {
    let declared = |line: &str| refused(&(line.to_owned() + "\n" + &body("return vec3(0.1);")));
    for (line, expected) in [
        ("// @parameter a | A | number | 2 | 0..1 | | H.", "line 1: the default is not in the range 0 to 1"),
        ("// @parameter a | A | number | nan | 0..1 | | H.", "is not a number"),
        ("// @parameter a | A | number | 0.5 | 1..0 | | H.", "from a lower to a higher"),
        ("// @parameter a | A | number | 0.5 | 0-1 | | H.", "two numbers with .. between"),
        ("// @parameter a | A | flag | 0.5 | 0..1 | | H.", "the kind is number or color"),
        ("// @parameter a | A | color | 0.5 | 0..1 | | H.", "a color three"),
        ("// @parameter a | A | number", "has 7 fields"),
        ("// @parameter A b | A | number | 0.5 | 0..1 | | H.", "is not a name"),
        ("// @parameter bump | A | number | 0.5 | 0..1 | | H.", "is the name of a map"),
        ("// @parameter roughness | A | number | 0.5 | 0..9 | | H.", "in other models"),
        ("// @parameter roughness | A | color | 0 0 0 | 0..1 | | H.", "in other models"),
    ] {
        let told = declared(line);
        assert!(told.contains(expected) && told.starts_with("line 1: "), "{line}: {told}");
    }
    let twice = declared("// @parameter x | X | number | 0.5 | 0..1 | | H.");
    assert!(twice.starts_with("line 2: the parameter x is declared twice"), "{twice}");
    let fn_name = declared("// @parameter fn | X | number | 0.5 | 0..1 | | H.");
    assert!(fn_name.contains("fn") || fn_name.contains("keyword"), "a reserved word: {fn_name}");
    let many: String = (0..40).map(|i| format!("// @parameter a{i}x | A | number | 0.5 | 0..1 | | H.\n")).collect();
    assert!(declared(&many).contains("more than 32"));
}

#[test]
fn what_never_ends_or_is_no_reflectance_is_refused() {
    for text in [
        "var i = 0; loop { i += 1; if i < 0 { break; } } return vec3(0.1);",
        "var s = 0.0; for (var i = 0u; i < 100000u; i++) { s += 1e-9; } return vec3(s);",
    ] {
        let told = refused(&body(text));
        assert!(told.contains("does not end within 4096 turns"), "{told}");
    }
    let calls: String =
        (1..20).map(|i| format!("fn f{i}_(x: f32) -> f32 {{ return f{}_(x) + f{}_(x); }}\n", i - 1, i - 1)).collect();
    let told = refused(&with(&format!(
        "fn f0_(x: f32) -> f32 {{ return x; }}\n{calls}fn brdf(p: Parameters, wi: vec3<f32>, wo: vec3<f32>) -> vec3<f32> {{ return vec3(f19_(0.0)); }}"
    )));
    assert!(told.contains("does not end"), "{told}");
    let chain: String = (1..70).map(|i| format!("fn f{i}_(x: f32) -> f32 {{ return f{}_(x); }}\n", i - 1)).collect();
    let called = |depth: u32| {
        with(&format!(
            "fn f0_(x: f32) -> f32 {{ return x; }}\n{chain}fn brdf(p: Parameters, wi: vec3<f32>, wo: vec3<f32>) -> vec3<f32> {{ return vec3(f{depth}_(0.1)); }}"
        ))
    };
    let told = refused(&called(69));
    assert!(told.contains("does not end"), "{told}");
    assert!(Written::new(&called(30)).is_ok(), "negative control");
    let told = refused(&body("return vec3(0.0) / (wi.z - wi.z);"));
    assert!(told.contains("which is not a reflectance for wi"), "{told}");
    assert!(refused(&body("return vec3(-0.1);")).contains("not a reflectance"));
    assert!(refused(&body("return vec3(sqrt(p.x - 0.4));")).contains("x = "), "found between the bounds");
    assert!(Written::new(&body("return vec3(0.3);")).is_ok(), "negative control");
}

#[test]
fn what_is_unusual_is_told_and_not_refused() {
    let remarks = |text: &str| Written::new(&body(text)).unwrap().remarks().join("; ");
    assert!(remarks("return vec3(0.9);").contains("reflects up to 2.8"), "{}", remarks("return vec3(0.9);"));
    assert!(remarks("return vec3(0.1 + 0.1 * wi.z);").contains("not reciprocal"));
    assert_eq!(remarks("return vec3(0.1 + 0.1 * wi.z * wo.z);"), "");
}

#[test]
fn modules_for_shaders_have_names_of_their_own_and_count_their_loops() {
    let text = body("var s = 0.0; for (var i = 0; i < 4; i++) { s += 0.01; } return vec3(s);");
    let written = Written::new(&text).unwrap();
    let wgsl = written.wgsl("mine_").unwrap();
    assert!(wgsl.contains("struct mine_Parameters") && wgsl.contains("fn mine_brdf(p: mine_Parameters"), "{wgsl}");
    assert!(wgsl.contains("> 4096u"), "{wgsl}");
    let twice = wgsl + &written.wgsl("yours_").unwrap();
    naga::front::wgsl::parse_str(&twice).unwrap();
    assert_eq!(written.parameters()[0].default, Value::Number(0.5));
    assert_eq!(BrdfModel::declared("x").map(|p| p.unit), Some("m"));
    let again = Written::new(&(text + "// A remark.\n")).unwrap();
    assert!(std::ptr::eq(again.parameters(), written.parameters()), "a list is kept once");
}
