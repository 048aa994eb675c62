import numpy as np, mitsuba as mi, sys
mi.set_variant("llvm_ad_rgb")
import urushi
from benchmarks.experiments.bottoms import *
from urushi.nets import code_fit, lobe as lobes, transmittance, basis as B
from urushi.nets.weights import default_model
m=default_model(); net=m.networks; bs=net.basis
rng=np.random.default_rng(3)
wi,wo=direction_sets.cosine_pairs(rng,8192)
w1,w2=direction_sets.cosine_pairs(rng,4096)
rowsA=bs.at(wi,wo); rowsB=bs.at(w1,w2)
pw=net.pairs()
for name in sys.argv[1:]:
    for cn,coat in COATS.items():
        d=filled({**coat,"bottom":BOTTOMS[name]})
        t=mi.load_dict({"type":"neural_layered",**d})
        fA=values(t,wi,wo,1)[0].T; fB=values(t,w1,w2,1)[0].T; fP=values(t,*pw,1)[0].T
        eta=coat.get("int_ior",1.5046)
        top=np.asarray(lobes.of_coat(np.array([coat["alpha"]]),np.array([eta]))[0],np.float32).reshape(1,-1)
        def split(f,a,b):
            ps=transmittance.both_ways(top[:,None],a,b)
            return np.maximum(f-lobes.f(top[:,None],a,b),0)/ps, np.broadcast_to(ps,f.shape)
        gA,pA=split(fA,wi,wo); gB,pB=split(fB,w1,w2); gP,pP=split(fP,*pw)
        meas=np.full(len(wi),1/len(wi),np.float32)
        out=[]
        for which in ("probes","full"):
            if which=="probes": c=code_fit.fitted(bs.probe_rows(0.),bs.measure*pP,bs.prior,gP)
            else: c=code_fit.fitted(rowsA,meas*pA,bs.prior,gA)
            fh=np.exp(c@rowsB[:,1:].T+rowsB[:,0])*pB+lobes.f(top[:,None],w1,w2)
            fa=np.exp(c@rowsA[:,1:].T+rowsA[:,0])*pA+lobes.f(top[:,None],wi,wo)
            out.append((np.round(100*stack_error(fh,fB,w1[:,2],w2[:,2]),2), np.round(100*(fa.sum(1)/fA.sum(1)-1),2)))
        print(name,cn,*out,flush=True)
