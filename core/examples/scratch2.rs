use glam::*; use lapidary_core::{scene::*, ray::*, sphere::*, light_tree::*};
use rayon::prelude::*;
fn main(){
  let (models,_)=tobj::load_obj("/work/shared/data/models/armadillo-plane/armadillo-plane.obj",&tobj::LoadOptions{triangulate:true,single_index:true,..Default::default()}).unwrap();
  let mut m=Mesh::default(); let mut plane0=0;
  for md in models { let b=m.positions.len() as u32; plane0=b as usize; m.positions.extend(md.mesh.positions.chunks(3).map(Vec3::from_slice)); m.triangles.extend(md.mesh.indices.chunks(3).map(|c|[c[0]+b,c[1]+b,c[2]+b])); }
  let mut n=vec![Vec3::ZERO;m.positions.len()];
  for t in 0..m.triangles.len(){let a=m.area_vector(t); for v in m.triangles[t]{n[v as usize]+=a;}}
  let n:Vec<Vec3>=n.into_iter().map(|x|x.normalize_or(Vec3::Y)).collect();
  let sc=Intersector::new(&m);
  let nl=32768; let dirs=fibonacci_directions(nl); let set=DirectionSet::new(&dirs); let eps=2e-4;
  let row=|v:usize,ts:bool|{let nn=n[v]; let mut vis=vec![0u8;nl]; sc.trace_batch(m.positions[v]+nn*eps,&set,|d|d.dot(nn)>0.0,&mut vis); if ts && v>=plane0 {sc.trace_batch(m.positions[v]-nn*eps,&set,|d|d.dot(nn)<=0.0,&mut vis);} vis};
  // pilot: 1024 "clusters" of 4 members, crude: random vertices
  let nv=m.positions.len();
  for ts in [false,true] {
  let mut order:Vec<usize>=(0..nv).collect(); order.sort_by_key(|&v|{let p=m.positions[v]; let q=((p+Vec3::splat(8.0))*64.0).as_uvec3(); let mut k=0u64; for b in 0..10{k|=((q.x as u64>>b&1)<<(3*b))|((q.y as u64>>b&1)<<(3*b+1))|((q.z as u64>>b&1)<<(3*b+2));} k});
  let mm=1024; let mem=4;
  let mut pilot=vec![0f32;nl*mm];
  let rows:Vec<Vec<f32>>=(0..mm).into_par_iter().map(|c|{let mut acc=vec![0f32;nl]; for j in 0..mem{let v=order[(c*nv/mm+j*(nv/mm)/mem).min(nv-1)]; for (a,x) in acc.iter_mut().zip(row(v,ts)){*a+=x as f32/mem as f32;}} acc}).collect();
  for (c,r) in rows.iter().enumerate(){for (l,&x) in r.iter().enumerate(){pilot[l*mm+c]=x;}}
  let test:Vec<Vec<u8>>=(0..600).into_par_iter().map(|i|row((i*7919*13+5)%nv,ts)).collect();
  let cut=|order:&[u32]|->(f64,f64){ let r:Vec<(usize,f64)>=test.par_iter().map(|vis|{ let mut cnt=vec![0u32;2*nl]; for (i,&s) in order.iter().enumerate(){cnt[nl+i]=vis[s as usize] as u32;} for i in (1..nl).rev(){cnt[i]=cnt[2*i]+cnt[2*i+1];} let mut st=vec![1usize]; let (mut k,mut e)=(0,0.0); while let Some(i)=st.pop(){ let c=(nl>>i.ilog2()) as f64; let mu=cnt[i] as f64/c; let er=c*(mu-mu*mu); if er>4.0{st.push(2*i);st.push(2*i+1);}else{k+=1;e+=er;} } (k,e)}).collect(); (r.iter().map(|x|x.0 as f64).sum::<f64>()/600.0,(r.iter().map(|x|x.1).sum::<f64>()/600.0/nl as f64).sqrt())};
  let t0=std::time::Instant::now(); let g=LightTree::geometric(nl).unwrap(); let tg=t0.elapsed(); println!("ts {ts} geometric {:?} {:?}",cut(g.order()),tg);
  for vs in [0.1f32,0.3,1.0,3.0,10.0,100.0]{ let t0=std::time::Instant::now(); let t=LightTree::build(&Features::mixed(&dirs,&pilot,TreeMetric{beta:0.5,visibility_scale:vs})).unwrap(); let e=t0.elapsed(); let tight:f64=(256..512).map(|i|t.mean_directions()[i].length() as f64).map(|r|(1.0-r)).sum::<f64>()/256.0; println!("vs {vs} {:?} spread {tight:.5} {:?}",cut(t.order()),e); }
  let tight:f64=(256..512).map(|i|g.mean_directions()[i].length() as f64).map(|r|(1.0-r)).sum::<f64>()/256.0; println!("geo spread {tight:.5}");
  }
}
