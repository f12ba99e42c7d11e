use lapidary_render::*; use lapidary_core::{dataset::Dataset,environment::Environment,camera::Camera,material::*}; use glam::Vec3;
struct P; impl Progress for P { fn advanced(&self,_:u64,_:u64){} }
fn main(){
  let a:Vec<String>=std::env::args().collect();
  let mut d=Dataset::read(a[1].as_ref()).unwrap();
  let size:Vec<u32>=a[3].split('x').map(|x|x.parse().unwrap()).collect();
  let env=if a[2].contains('.') {Environment::read(a[2].as_ref()).unwrap().0} else {Environment::from_spec(&a[2]).unwrap().0};
  let light=Illumination{environment:env,rotation:0.0,intensity:1.0};
  let mut view=View::new(Camera::look_at(Vec3::new(0.3,0.5,3.5),Vec3::ZERO,40.0),[size[0],size[1]]); view.background=Background::Black;
  for alpha in a[4].split(',').map(|x|x.parse::<f32>().unwrap()) {
  let m=Material{parameters:BrdfParameters{base_color:Vec3::ZERO,roughness:alpha.sqrt(),..Default::default()},..Default::default()};
  for x in &mut d.scene.materials {*x=m.clone();}
  let r=Renderer::new(&d);
  let t=std::time::Instant::now(); let reference=r.samples_reference(&view,&light,&P); let ts=t.elapsed();
  reference.write(format!("/tmp/out/ref-{alpha}.exr").as_ref()).unwrap(); reference.write(format!("/tmp/out/ref-{alpha}.png").as_ref()).unwrap();
  for k in a[5].split(',').map(|x|x.parse::<u32>().unwrap()) { for s in [BrdfSampling::Once,BrdfSampling::Refine] {
    let (im,st)=r.render(&view,&light,k,s); let m=compare::compare(&im,&reference).unwrap();
    println!("alpha {alpha} cut {k} {s:?} rel_rmse {:.4} evals {:.1} merged {:.1} time {:.3} shaded {} ref {:?}",m.rel_rmse,st.mean_brdf_evaluations,st.mean_merged_nodes,st.seconds,st.pixels_shaded,ts);
    im.write(format!("/tmp/out/im-{alpha}-{k}-{s:?}.png").as_ref()).unwrap();
  }}}
}
