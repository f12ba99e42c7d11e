use glam::*; use lapidary_core::{scene::*, ray::*, sphere::*};
fn main(){
  let (models,_)=tobj::load_obj("/work/shared/data/models/armadillo-plane/armadillo-plane.obj",&tobj::LoadOptions{triangulate:true,single_index:true,..Default::default()}).unwrap();
  let mut m=Mesh::default();
  for md in models { let b=m.positions.len() as u32; m.positions.extend(md.mesh.positions.chunks(3).map(Vec3::from_slice)); m.triangles.extend(md.mesh.indices.chunks(3).map(|c|[c[0]+b,c[1]+b,c[2]+b])); }
  let mut n=vec![Vec3::ZERO;m.positions.len()];
  for t in 0..m.triangles.len(){let a=m.area_vector(t); for v in m.triangles[t]{n[v as usize]+=a;}}
  let n:Vec<Vec3>=n.into_iter().map(|x|x.normalize_or(Vec3::Y)).collect();
  let t0=std::time::Instant::now(); let sc=Intersector::new(&m); println!("build {:?}",t0.elapsed());
  let nl:usize=std::env::args().nth(1).map_or(32768,|s|s.parse().unwrap());
  let dirs=fibonacci_directions(nl);
  let set=DirectionSet::new(&dirs);
  let eps=2e-4; let step=m.positions.len()/400;
  let mut vis=vec![0u8;nl]; let (mut traced,mut pairs,mut open)=(0u64,0u64,0u64);
  let t0=std::time::Instant::now();
  for v in (0..m.positions.len()).step_by(step){ vis.fill(0); let nn=n[v]; traced+=sc.trace_batch(m.positions[v]+nn*eps,&set,|d|d.dot(nn)>0.0,&mut vis); pairs+=nl as u64; open+=vis.iter().map(|&x|x as u64).sum::<u64>(); }
  let s=t0.elapsed().as_secs_f64(); println!("{} pairs {:.1} M pairs/s/core, rays {:.1} M/s, open {:.3} of traced",pairs,pairs as f64/s/1e6,traced as f64/s/1e6,open as f64/traced as f64);
  
  let mut bad=0; let mut cnt=0; 
  for v in (0..m.positions.len()).step_by(step*7){ vis.fill(0); let nn=n[v]; let o=m.positions[v]+nn*eps; sc.trace_batch(o,&set,|d|d.dot(nn)>0.0,&mut vis); for i in (0..nl).step_by(61){ if dirs[i].dot(nn)>0.0 {cnt+=1; let b=!sc.occluded_by_brute_force(o,dirs[i]); if b!=(vis[i]==1){bad+=1;} if b==sc.occluded(o,dirs[i]){bad+=1;}}}}
  println!("mismatch {bad} of {cnt}");
}
