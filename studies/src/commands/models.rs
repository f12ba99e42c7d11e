//! The `models` command.

use crate::{
    outputs::CommandFiles,
    terminal::{json_text, print_out},
};
use anyhow::Result;
use clap::Args;
use lapidary_core::{
    brdf::{BrdfModel, Parameter, Value},
    material::{PRESETS, Preset},
};
use serde_json::json;

/// Options of `models`.
#[derive(Args, Clone, Debug)]
pub struct ModelsArgs {
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

impl ModelsArgs {
    /// Files: none.
    pub fn files(&self) -> CommandFiles {
        CommandFiles::default()
    }

    /// Prints all BRDF models with their parameters.
    ///
    /// # Errors
    /// Standard output cannot be written.
    pub fn run(&self) -> Result<()> {
        if self.json { print_out(&json_text(&models_json())?) } else { print_out(&models_text()) }
    }
}

/// All parameters of a model, and whether each is rendered or only stored.
fn listed(model: BrdfModel) -> impl Iterator<Item = (&'static Parameter, bool)> {
    let rendered = model.parameters().iter().map(|p| (p, true));
    rendered.chain(model.stored_parameters().iter().map(|p| (p, false)))
}

fn models_json() -> serde_json::Value {
    let parameter = |(p, rendered): (&Parameter, bool)| {
        json!({
            "name": p.name,
            "label": p.label,
            "kind": if p.is_color() { "color" } else { "number" },
            "unit": p.unit,
            "range": p.range,
            "default": p.default,
            "help": p.help,
            "rendered": rendered,
        })
    };
    let model = |&model: &BrdfModel| {
        json!({
            "model": model.key(),
            "label": model.label(),
            "summary": model.summary(),
            "file": model.has_file(),
            "parameters": listed(model).map(parameter).collect::<Vec<_>>(),
        })
    };
    let preset = |p: &Preset| json!({ "name": p.name, "group": p.group, "source": p.source, "model": p.model.key() });
    json!({
        "models": BrdfModel::ALL.iter().map(model).collect::<Vec<_>>(),
        "presets": PRESETS.iter().map(preset).collect::<Vec<_>>(),
    })
}

fn models_text() -> String {
    let mut text = String::new();
    for model in BrdfModel::ALL {
        let file = if model.has_file() { " Its materials name a `file`." } else { "" };
        text += &format!("{}: {}{file}\n", model.key(), model.summary());
        for (p, rendered) in listed(*model) {
            let [low, high] = p.range;
            let default = match p.default {
                Value::Number(x) => x.to_string(),
                Value::Color(c) => format!("{},{},{}", c.x, c.y, c.z),
            };
            let unit = if p.unit.is_empty() { String::new() } else { format!(" {}", p.unit) };
            let mark = if rendered { "" } else { ", stored and not rendered" };
            text += &format!("  {:36} {low} to {high}{unit}, default {default}{mark}\n", p.name);
        }
    }
    text += "\npresets, for --material preset:NAME\n";
    for group in PRESETS.chunk_by(|a, b| a.group == b.group) {
        let names: Vec<&str> = group.iter().map(|preset| preset.name).collect();
        text += &format!("  {}: {}\n", group[0].group, names.join(", "));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_model_and_parameter_is_listed() {
        let (text, json) = (models_text(), models_json());
        for (i, model) in BrdfModel::ALL.iter().enumerate() {
            assert!(text.contains(&format!("{}: ", model.key())));
            let listed = &json["models"][i];
            assert_eq!(listed["model"], model.key());
            for (j, p) in model.parameters().iter().enumerate() {
                assert!(text.contains(&format!("  {} ", p.name)), "{}", p.name);
                assert_eq!(listed["parameters"][j]["name"], p.name);
                assert_eq!(listed["parameters"][j]["rendered"], true);
            }
            let all = listed["parameters"].as_array().unwrap();
            let stored: Vec<_> = all.iter().filter(|p| p["rendered"] == false).map(|p| p["name"].clone()).collect();
            let expected: Vec<&str> = model.stored_parameters().iter().map(|p| p.name).collect();
            assert_eq!(stored, expected);
            assert_eq!(stored.is_empty(), *model != BrdfModel::OpenPbr);
        }
        assert!(!text.contains("no_such_parameter"));
        let marked = text.lines().filter(|line| line.ends_with(", stored and not rendered")).count();
        assert_eq!(marked, BrdfModel::OpenPbr.stored_parameters().len());
        assert!(text.contains("Gold, Silver") && json["presets"][0]["name"] == "Chalk");
    }
}
