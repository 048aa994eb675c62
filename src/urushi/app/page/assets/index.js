var e,t,n,r,i,a,o,s,c,l,u,d=Symbol.for(`pv`),f={},p=[],m=/^m(i|n|o|s|text|space)$/,h=Array.isArray,g=p.slice,_=Object.assign;function v(e){e&&e.parentNode&&e.remove()}function y(e,t,n){var r,i,a,o={},s=arguments.length;for(a in t)a==`key`?r=t[a]:a==`ref`&&typeof e!=`function`?i=t[a]:o[a]=t[a];return s>2&&(o.children=s>3?g.call(arguments,2):n),b(e,o,r,i,null)}function b(n,r,i,a,o){var s={type:n,props:r,key:i,ref:a,__k:null,__:null,__b:0,__e:null,__c:null,constructor:d,__v:o||++t,__i:-1,__u:0};return!o&&e.vnode&&e.vnode(s),s}function x(e){return e.children}function S(e,t){this.props=e,this.context=t,this.__g=0}function C(e,t){if(t==null)return e.__&&C(e.__,e.__i+1);for(var n;t<e.__k.length;t++)if((n=e.__k[t])&&n.__e)return n.__e;return typeof e.type!=`function`||e.props.__P?null:C(e)}function ee(t){var n,r=t.__v,i=r.__e,a=[],o=[],s=t.__P;s&&((n=_({constructor:d},r)).__v=r.__v+1,e.vnode&&e.vnode(n),ce(s,n,r,t.__n,s.namespaceURI,32&r.__u?[i]:null,a,i||C(r),32&r.__u,o),n.__v=r.__v,n.__.__k[n.__i]=n,de(a,n,o),r.__=r.__e=null,n.__e!=i&&w(n))}function w(e){if((e=e.__)&&e.__c&&!e.props.__P)return e.__e=null,e.__k.some(function(t){return t&&(e.__e=t.__e)}),w(e)}function T(t){(8&t.__g||(t.__g|=8,r.push(t),a++))&&i==e.debounceRendering||((i=e.debounceRendering)||queueMicrotask)(E)}function E(){try{for(var e,t=1;r.length;)r.length>t&&r.sort(o),e=r.shift(),t=r.length,8&e.__g&&ee(e)}finally{(a=r.length)&&(i||queueMicrotask)(E)}}function te(e,t,n,r,i,a,o,s,c,l,u){var d,m,h,g,_,v,y=r.__k||p,b=t.length;for(c=ne(n,t,y,c,b),d=0;d<b;d++)(h=n.__k[d])!=null&&(m=~h.__i&&y[h.__i]||f,h.__i=d,v=ce(e,h,m,i,a,o,s,c,l,u),g=h.__e,(m.ref!=h.ref||8&m.__u)&&(m.ref&&pe(m.ref,null,h,m),h.ref&&u.push(h.ref,h.__c||g,h)),_||=g,4&h.__u?(c=re(h,c,e,!m.__v),m.__e&&(m.__e=null)):typeof h.type==`function`&&v!==void 0?c=v:g&&(c=g.nextSibling),h.__u&=-21);return n.__e=_,c}function ne(e,t,n,r,i){var a,o,s,c,l,u,f,p,m,g=n.length,_=g,v=0,y=0,S=e.__k=Array(i);for(a=0;a<i;a++)(o=t[a])!=null&&typeof o!=`boolean`&&typeof o!=`function`?(typeof o!=`object`||o.constructor===String?o=S[a]=b(null,o):h(o)?o=S[a]=b(x,{children:o}):o.constructor===d&&o.__b?o=S[a]=b(o.type,o.props,o.key,o.ref,o.__v):S[a]=o,c=a+v,o.__=e,o.__b=e.__b+1,s=null,~(l=o.__i=ie(o,n,c,_))&&(_--,(s=n[l])&&(s.__u|=2)),s&&s.__v?(o.__u|=16,l==c-1?v--:l==c+1?v++:l!=c&&(l>c?v--:v++,y=1)):(~l||(i>g?v--:i<g&&v++),typeof o.type!=`function`&&(o.__u|=4))):S[a]=null;if(y){for(u=[],f=[],a=0;a<i;a++)if((o=S[a])&&16&o.__u){for(v=0,p=u.length;v<p;)u[m=v+p>>1]<o.__i?v=m+1:p=m;u[v]=o.__i,f[a]=v+1}for(v=u.length;a--;)f[a]&&(f[a]==v?v--:S[a].__u|=4)}if(_)for(a=0;a<g;a++)!(s=n[a])||2&s.__u||(s.__e==r&&(r=C(s)),me(s,s));return r}function re(e,t,n,r){var i,a,o,s;if(typeof e.type==`function`){if(e.props.__P)return t;if(i=e.__k)for(a=0;a<i.length;a++)i[a]&&(i[a].__=e,t=re(i[a],t,n,!1));return t}for(t&&!t.parentNode&&(t=C(e))&&!t.parentNode&&(t=null),o=e.__e,s=t;s&&s.nodeType==8;)s=s.nextSibling;for(o!=s&&(!r&&n.moveBefore&&o.parentNode?n.moveBefore(o,t):n.insertBefore(o,t||null)),t=o;(t&&=t.nextSibling)&&t.nodeType==8&&!t.data.startsWith(`$s`););return t}function ie(e,t,n,r){var i,a=e.key,o=e.type,s=t[n],c=s&&!(2&s.__u);if(s===null&&a==null||c&&a==s.key&&o==s.type)return n;if(r>+!!c){for(i=n-1;i>=0;i--)if((s=t[i])&&!(2&s.__u)&&a==s.key&&o==s.type)return i;for(i=n+1;i<t.length;i++)if((s=t[i])&&!(2&s.__u)&&a==s.key&&o==s.type)return i}return-1}function ae(e,t,n){n??=``,t[0]==`-`?e.setProperty(t,n):e[t]=n}function oe(e,t,n,r,i){var a,o;if(t==`style`){if(typeof n==`string`)e.style.cssText=n;else{if(typeof r==`string`&&(e.style.cssText=r=``),r)for(t in r)n&&t in n||ae(e.style,t);if(n)for(t in n)r&&n[t]==r[t]||ae(e.style,t,n[t])}}else if(t[0]==`o`&&t[1]==`n`)typeof n!=`function`&&(n=null),typeof r!=`function`&&(r=null),(e.__e||={})[t]=n,n&&r||(o=u[t]||(u[t]=se(t)),(e.__a||={})[t]=l,a=t!=(t=t.replace(c,`$1`)),(t=t.slice(2))[0]<`a`&&(t=t.toLowerCase()),n?e.addEventListener(t,o,a):e.removeEventListener(t,o,a));else{if(i==`http://www.w3.org/2000/svg`)t=t.replace(/xlink(H|:h)/,`h`).replace(/sName$/,`s`);else if(t!=`width`&&t!=`height`&&t!=`href`&&t!=`list`&&t!=`form`&&t!=`tabIndex`&&t!=`download`&&t!=`rowSpan`&&t!=`colSpan`&&t!=`role`&&t!=`popover`&&t in e)try{e[t]=n??``;return}catch{}if(typeof n==`function`)return;n==null||!1===n&&t[4]!=`-`?e.removeAttribute(t):e.setAttribute(t,t==`popover`&&n==1?``:n)}}function se(t){return function(n){var r=this.__e;if(r){if(r=r[t],n[s]==null)n[s]=l++;else if(n[s]<this.__a[t])return;return r(e.event?e.event(n):n)}}}function ce(t,n,r,i,a,o,s,c,l,u){var f,m,g,y,b,ee,w,T,E,ne,re,ie,ae,oe,se,ce,de,pe,D=n.type;if(n.constructor!==d)return null;128&r.__u&&(l=32&r.__u,f=r.__c.__z)&&(n.__u|=l,m=o=[],f.nodeType==8?c=le(f,o):o.push(f),c=o[0]||c),(f=e.__b)&&f(n);n:if(typeof D==`function`){g=s.length;try{if(T=n.props,E=(f=D.prototype)&&f.render,ne=(f=D.contextType)&&i[f.__c],re=f?ne?ne.props.value:f.__:i,(y=r.__c)?(n.__c=y,2&y.__g&&(y.__g|=1)):(E?n.__c=y=new D(T,re):(n.__c=y=new S(T,re),y.constructor=D,y.render=he),ne&&ne.sub(y),y.state||(y.state={}),y.__n=i,y.__g|=8,y.__h=[],y.__k=[]),E&&(y.__s||(y.__s=y.state),D.getDerivedStateFromProps&&(y.__s==y.state&&(y.__s=_({},y.__s)),_(y.__s,D.getDerivedStateFromProps(T,y.__s)))),b=y.props,ee=y.state,y.__v=n,r.__c){if(T!==b&&E&&!D.getDerivedStateFromProps&&y.componentWillReceiveProps&&y.componentWillReceiveProps(T,re),n.__v==r.__v&&!(8&y.__g)||!(4&y.__g)&&y.shouldComponentUpdate&&!1===y.shouldComponentUpdate(T,y.__s,re)){n.__v!=r.__v&&(y.props=T,y.state=y.__s,y.__g&=-9),n.__e=r.__e,n.__k=r.__k,n.__k.some(function(e){e&&(e.__=n)}),p.push.apply(y.__h,y.__k),y.__k=[],y.__h.length&&s.push(y),c=C(r);break n}y.componentWillUpdate&&y.componentWillUpdate(T,y.__s,re),E&&y.componentDidUpdate&&y.__h.push(function(){y.componentDidUpdate(b,ee,w)})}else E&&!D.getDerivedStateFromProps&&y.componentWillMount&&y.componentWillMount(),E&&y.componentDidMount&&y.__h.push(y.componentDidMount);y.context=re,y.props=T,y.__P=t,y.__g&=-5,ie=e.__r,ae=E?25:0;do y.__g&=-9,ie&&ie(n),f=y.render(y.props,y.state=y.__s,y.context);while(8&y.__g&&++ae<25);E&&(p.push.apply(y.__h,y.__k),y.__k=[]),y.state=y.__s,y.getChildContext&&(i=_({},i,y.getChildContext())),E&&r.__c&&y.getSnapshotBeforeUpdate&&(w=y.getSnapshotBeforeUpdate(b,ee)),oe=f&&f.type===x&&f.key==null?f.props.children:f,T.__P&&(f=c,a=(t=T.__P).namespaceURI,l=o=null,r.props&&r.props.__P!=t&&(r.__k.some(function(e){e&&me(e,e)}),r.__k=null),c=r.__k?C(r,0):null),c=te(t,h(oe)?oe:[oe],n,r,i,a,o,s,c,l,u),T.__P&&(n.__e=null,c=f),n.__u&=-161,m&&m.some(v),y.__h.length&&s.push(y),1&y.__g&&(y.__g&=-4)}catch(t){if(s.length=g,n.__v=null,l||o){if(t&&t.then){if(n.__u|=128|l,o){for(~(de=o.indexOf(c||void 0))||(de=o.length);(pe=o[de-1])&&pe.nodeType==8;)de--;for(;de<o.length;de++)if(pe=o[de]){if(o[de]=null,se){if(pe==ce)break}else{if(pe.nodeType!=8)break;pe.data.startsWith(`$s`)&&(ce=le(se=pe))}}}if(!se){for(;c&&c.nodeType==8&&c.nextSibling;)c=c.nextSibling;se=c}(f=le(se=n.__c.__z||(n.__c.__z=se)))?(n.__e=se,c=f):n.__e=c,c&&=c.nextSibling}else o&&o.some(v)}else n.__e=r.__e;n.__k||=r.__k||[],t&&t.then||ue(n),e.__e(t,n,r)}}else c=n.__e=fe(r.__e,n,r,i,a,o,s,l,u,t);return(f=e.diffed)&&f(n),c}function le(e,t){if(e&&e.nodeType==8&&e.data.startsWith(`$s`))for(var n=1;e=e.nextSibling;){if(e.nodeType==8){if(e.data.startsWith(`$s`))n++;else if(e.data.startsWith(`/$s`)&&!--n)return e}t&&t.push(e)}}function ue(e){e&&(e.__c&&(e.__c.__g|=4),e.__k&&e.__k.some(ue))}function de(t,n,r){for(var i=0;i<r.length;)pe(r[i++],r[i++],r[i++]);e.__c&&e.__c(n,t),t.some(function(n){try{t=n.__h,n.__h=[],t.some(function(e){e.call(n)})}catch(t){e.__e(t,n.__v)}})}function fe(t,n,r,i,a,o,s,c,l,u){var d,p,_,y,b,x,S,ee,w=r.props||f,T=n.props,E=n.type;if(E==`svg`?a=`http://www.w3.org/2000/svg`:E==`math`?a=`http://www.w3.org/1998/Math/MathML`:a||=`http://www.w3.org/1999/xhtml`,o){for(d=0;d<o.length;d++)if((b=o[d])&&(E?b.localName==E:b.nodeType==3)){t=b,o[d]=null;break}}if(!t){if(ee=u.ownerDocument||document,!E)return ee.createTextNode(T);t=ee.createElementNS(a,E,T.is?T:u),c&&=(e.__m&&e.__m(n,o),!1),o=null}if(E){if(u=E==`template`&&t.content||t,o=E==`textarea`&&T.defaultValue!=null?null:o&&g.call(u.childNodes),!c&&o)for(w={},d=0;d<t.attributes.length;d++)w[(b=t.attributes[d]).name]=b.value;for(d in w)b=w[d],d==`dangerouslySetInnerHTML`?_=b:d==`children`||d in T||d==`value`&&`defaultValue`in T||d==`checked`&&`defaultChecked`in T||oe(t,d,null,b,a);for(d in T)b=T[d],d==`children`?y=b:d==`dangerouslySetInnerHTML`?p=b:d==`value`?x=b:d==`checked`?S=b:c&&typeof b!=`function`||w[d]===b||oe(t,d,b,w[d],a);p?(c||_&&(p.__html==_.__html||p.__html==t.innerHTML)||(t.innerHTML=p.__html),n.__k=[]):(_&&(t.textContent=``),(E==`foreignObject`||a==`http://www.w3.org/1998/Math/MathML`&&m.test(E))&&(a=`http://www.w3.org/1999/xhtml`),te(u,h(y)?y:[y],n,r,i,a,o,s,o?o[0]:r.__k&&C(r,0),c,l),o&&o.some(v)),c&&E!=`textarea`||(d=`value`,E==`progress`&&x==null?t.removeAttribute(d):x==null||x===t[d]&&(E!=`progress`||x)||oe(t,d,x,w[d],a),d=`checked`,S!=null&&S!=t[d]&&oe(t,d,S,w[d],a))}else w===T||c&&t.data==T||(t.data=T);return t}function pe(t,n,r,i){try{typeof t==`function`?n?n.__x=t(n)||1:(i&&=i.__c||i.__e)&&(n=i.__x)&&(i.__x=null,typeof n==`function`?n():t(null)):t.current=n}catch(t){e.__e(t,r)}}function me(t,n,r){var i,a,o,s;if(e.unmount&&e.unmount(t),!(i=t.ref)||i.current&&i.current!=t.__e||pe(i,null,n,t),i=t.__c){if(i.componentWillUnmount)try{i.componentWillUnmount()}catch(t){e.__e(t,n)}i.__P=i.__n=null}if(i=t.__k)for(s=0;s<i.length;s++)i[s]&&me(i[s],n,typeof t.type!=`function`||r&&!t.props.__P);!r&&(i=t.__c)&&(i=i.__z)&&(a=le(i,o=[]))&&(i==t.__e&&o.some(v),v(a),v(i)),r||v(t.__e),t.__e=t.__c=t.__=null}function he(e,t,n){return this.constructor(e,n)}function D(t,n){var r,i,a,o;e.__&&e.__(t,n),n.nodeType==9&&(n=n.documentElement),i=(r=t&&32&t.__u)?null:n.__k,n.__k=b(x,{children:[t]}),a=[],o=[],ce(n,n.__k,i||f,f,n.namespaceURI,i?null:n.firstChild?g.call(n.childNodes):null,a,i?i.__e:n.firstChild,r,o),de(a,n.__k,o),n.__k.props.children=null}e={__e:function(e,t,n,r){for(var i,o,s;t=t.__;)if((i=t.__c)&&!(1&i.__g)){i.__g|=4;try{if((s=(o=i.constructor)&&o.getDerivedStateFromError)&&i.setState(o.getDerivedStateFromError(e)),i.componentDidCatch&&(i.componentDidCatch(e,r||{}),s=1),s&&8&i.__g)return void(i.__g|=2)}catch(t){e=t}}throw a=0,e}},t=0,n=function(e){return e!=null&&e.constructor===d},S.prototype.setState=function(e,t){var n=this.__s;n&&n!=this.state||(n=this.__s=_({},this.state)),typeof e==`function`&&(e=e(_({},n),this.props)),e&&(_(n,e),this.__v&&(t&&this.__k.push(t),T(this)))},S.prototype.forceUpdate=function(e){this.__v&&(this.__g|=4,e&&this.__h.push(e),T(this))},S.prototype.render=x,r=[],a=0,o=function(e,t){return e.__v.__b-t.__v.__b},s=Symbol(),c=/(PointerCapture)$|Capture$/i,l=0,u={};var ge,O,_e,ve,ye=Object.is,be=0,xe=[],Se=[],k=e,Ce=k.__b,we=k.__r,Te=k.diffed,Ee=k.__c,De=k.unmount,Oe=k.__;function ke(e,t){k.__h&&k.__h(O,e,be||t),be=0;var n=O.__H||(O.__H={__:[],__h:[]});return e>=n.__.length&&n.__.push({}),n.__[e]}function Ae(e,t){var n=ke(ge++,3);!k.__s&&Re(n.__H,t)&&(n.__P=!0,n.__=e,n.u=t,O.__H.__h.push(n))}function A(e){return be=5,je(function(){return{current:e}},[])}function je(e,t){var n=ke(ge++,7);return Re(n.__H,t)&&(n.__=e(),n.__H=t),n.__}function Me(){var e;do{for(;e=Se.shift();)try{Ie(e)}catch(t){k.__e(t,{__:(e=e.__P)&&e.__v})}for(;e=xe.shift();){var t=e.__H;if(e.__P&&t)try{t.__h.some(Ie),t.__h.some(Le),t.__h=[]}catch(n){t.__h=[],k.__e(n,e.__v)}}}while(Se.length)}k.__b=function(e){O=null,Ce&&Ce(e)},k.__=function(e,t){e&&t.__k&&t.__k.__m&&(e.__m=t.__k.__m),Oe&&Oe(e,t)},k.__r=function(e){we&&we(e),ge=0;var t=(O=e.__c).__H;t&&(_e==O?O.__h=[]:(t.__h.some(Ie),t.__h.some(Le),ge=0),t.__h=[],t.__.some(function(e){e.__N&&(e.__=e.__N),e.u=e.__N=void 0})),_e=O},k.diffed=function(e){Te&&Te(e);var t=e.__c;t&&t.__H&&(t.__H.__h.length&&Fe(xe.push(t)),t.__H.__.some(function(e){e.u&&(e.__H=e.u)})),_e=O=null},k.__c=function(e,t){t.some(function(e){try{e.__h.some(Ie),e.__h=e.__h.filter(function(e){return!e.__||Le(e)})}catch(t){e.__h=[function(){throw t}]}}),Ee&&Ee(e,t)},k.unmount=function(e){De&&De(e);var t,n,r=e.__c;r&&r.__H&&(r.__H.__.some(function(r){try{if(r.__P&&r.__c){if(n===void 0){for(n=e.__;n&&(!n.__c||!n.__c.__P);)n=n.__;n&&=n.__c}r.__P=n,Fe(Se.push(r))}else Ie(r)}catch(e){t=e}}),r.__H=void 0,t&&k.__e(t,r.__v))};var Ne=typeof requestAnimationFrame==`function`;function Pe(e){var t,n=function(){clearTimeout(r),Ne&&cancelAnimationFrame(t),setTimeout(e)},r=setTimeout(n,35);Ne&&(t=requestAnimationFrame(n))}function Fe(e){e!=1&&ve==k.requestAnimationFrame||((ve=k.requestAnimationFrame)||Pe)(Me)}function Ie(e){var t=O,n=e.__c;typeof n==`function`&&(e.__c=void 0,n()),O=t}function Le(e){var t=O;e.__c=e.__(),O=t}function Re(e,t){return!e||e.length!=t.length||t.some(function(t,n){return!ye(t,e[n])})}var ze=Symbol.for(`preact-signals`);function Be(){if(Ge>1)Ge--;else{var e,t=!1;for((function(){var e=Ye;for(Ye=void 0;e!==void 0;){var t=e.S;if(t.v===e.v)for(var n=t.t;n!==void 0;n=n.x)n.i===e.i&&(n.i=t.i);e=e.o}})();We!==void 0;){var n=We;for(We=void 0,Ke++;n!==void 0;){var r=n.u;if(n.u=void 0,n.f&=-3,!(8&n.f)&&Qe(n))try{n.c()}catch(n){t||=(e=n,!0)}n=r}}if(Ke=0,Ge--,t)throw e}}function Ve(e){if(Ge>0)return e();Je=++qe,Ge++;try{return e()}finally{Be()}}var He,j=void 0;function Ue(e){var t=j,n=He;j=void 0,He=void 0;try{return e()}finally{j=t,He=n}}var We=void 0,Ge=0,Ke=0,qe=0,Je=0,Ye=void 0,Xe=0;function Ze(e){if(j!==void 0){var t=e.n;if(t===void 0||t.t!==j)return t={i:0,S:e,p:j.s,n:void 0,t:j,e:void 0,x:void 0,r:t},j.s!==void 0&&(j.s.n=t),j.s=t,e.n=t,32&j.f&&e.S(t),t;if(t.i===-1)return t.i=0,t.n!==void 0&&(t.n.p=t.p,t.p!==void 0&&(t.p.n=t.n),t.p=j.s,t.n=void 0,j.s.n=t,j.s=t),t}}function M(e,t){this.v=e,this.i=0,this.n=void 0,this.t=void 0,this.l=0,this.W=t?.watched,this.Z=t?.unwatched,this.name=t?.name}M.prototype.brand=ze,M.prototype.h=function(){return!0},M.prototype.S=function(e){var t=this,n=this.t;n!==e&&e.e===void 0&&(e.x=n,this.t=e,n===void 0?Ue(function(){var e;(e=t.W)==null||e.call(t)}):n.e=e)},M.prototype.U=function(e){var t=this;if(this.t!==void 0){var n=e.e,r=e.x;n!==void 0&&(n.x=r,e.e=void 0),r!==void 0&&(r.e=n,e.x=void 0),e===this.t&&(this.t=r,r===void 0&&Ue(function(){var e;(e=t.Z)==null||e.call(t)}))}},M.prototype.subscribe=function(e){var t=this;return F(function(){var n=t.value;Ue(function(){return e(n)})},{name:`sub`})},M.prototype.valueOf=function(){return this.value},M.prototype.toString=function(){return this.value+``},M.prototype.toJSON=function(){return this.value},M.prototype.peek=function(){var e=this;return Ue(function(){return e.value})},Object.defineProperty(M.prototype,"value",{get:function(){var e=Ze(this);return e!==void 0&&(e.i=this.i),this.v},set:function(e){if(e!==this.v){if(Ke>100)throw Error(`Cycle detected`);(function(e){Ge!==0&&Ke===0&&e.l!==Je&&(e.l=Je,Ye={S:e,v:e.v,i:e.i,o:Ye})})(this),this.v=e,this.i++,Xe++,Ge++;try{for(var t=this.t;t!==void 0;t=t.x)t.t.N()}finally{Be()}}}});function N(e,t){return new M(e,t)}function Qe(e){for(var t=e.s;t!==void 0;t=t.n)if(t.S.i!==t.i||!t.S.h()||t.S.i!==t.i)return!0;return!1}function $e(e){for(var t=e.s;t!==void 0;t=t.n){var n=t.S.n;if(n!==void 0&&(t.r=n),t.S.n=t,t.i=-1,t.n===void 0){e.s=t;break}}}function et(e){for(var t=e.s,n=void 0;t!==void 0;){var r=t.p;t.i===-1?(t.S.U(t),r!==void 0&&(r.n=t.n),t.n!==void 0&&(t.n.p=r)):n=t,t.S.n=t.r,t.r!==void 0&&(t.r=void 0),t=r}e.s=n}function tt(e,t){M.call(this,void 0,t),this.x=e,this.s=void 0,this.g=Xe-1,this.f=4}tt.prototype=new M,tt.prototype.h=function(){if(this.f&=-3,1&this.f)return!1;if((36&this.f)==32||(this.f&=-5,this.g===Xe))return!0;if(this.g=Xe,this.f|=1,this.i>0&&!Qe(this))return this.f&=-2,!0;var e=j;try{$e(this),j=this;var t=this.x();(16&this.f||this.v!==t||this.i===0)&&(this.v=t,this.f&=-17,this.i++)}catch(e){this.v=e,this.f|=16,this.i++}return j=e,et(this),this.f&=-2,!0},tt.prototype.S=function(e){if(this.t===void 0){this.f|=36;for(var t=this.s;t!==void 0;t=t.n)t.S.S(t)}M.prototype.S.call(this,e)},tt.prototype.U=function(e){if(this.t!==void 0&&(M.prototype.U.call(this,e),this.t===void 0)){this.f&=-33;for(var t=this.s;t!==void 0;t=t.n)t.S.U(t)}},tt.prototype.N=function(){if(!(2&this.f)){this.f|=6;for(var e=this.t;e!==void 0;e=e.x)e.t.N()}},Object.defineProperty(tt.prototype,"value",{get:function(){if(1&this.f)throw Error(`Cycle detected`);var e=Ze(this);if(this.h(),e!==void 0&&(e.i=this.i),16&this.f)throw this.v;return this.v}});function P(e,t){return new tt(e,t)}function nt(e){var t=e.j;if(e.j=void 0,typeof t==`function`){Ge++;var n=j;j=void 0;try{t()}catch(t){throw e.f&=-2,e.f|=8,rt(e),t}finally{j=n,Be()}}}function rt(e){for(var t=e.s;t!==void 0;t=t.n)t.S.U(t);e.x=void 0,e.s=void 0,nt(e)}function it(e){if(j!==this)throw Error(`Out-of-order effect`);et(this),j=e,this.f&=-2;try{8&this.f&&rt(this)}finally{Be()}}function at(e,t){this.x=e,this.j=void 0,this.s=void 0,this.u=void 0,this.f=32,this.name=t?.name,He&&He.push(this)}at.prototype.c=function(){var e=this.S();try{if(8&this.f||this.x===void 0)return;var t=this.x();typeof t==`function`&&(this.j=t)}finally{e()}},at.prototype.S=function(){if(1&this.f)throw Error(`Cycle detected`);this.f|=1,this.f&=-9,nt(this),$e(this),Ge++;var e=j;return j=this,it.bind(this,e)},at.prototype.N=function(){2&this.f||(this.f|=2,this.u=We,We=this)},at.prototype.d=function(){this.f|=8,1&this.f||rt(this)},at.prototype.dispose=function(){this.d()};function F(e,t){var n=new at(e,t);try{n.c()}catch(e){throw n.d(),e}var r=n.d.bind(n);return r[Symbol.dispose]=r,r}var ot,st,ct=typeof window<`u`&&!!window.__PREACT_SIGNALS_DEVTOOLS__,lt=[];F(function(){ot=this.N})();function ut(t,n){e[t]=n.bind(null,e[t]||function(){})}function dt(e){if(st){var t=st;st=void 0,t()}st=e&&e.S()}function ft(e){var t=this,r=e.data,i=mt(r);i.name=`ReactiveDom`,i.value=r;var a=je(function(){for(var e=t,r=t.__v;r=r.__;)if(r.__c){r.__c.__$f|=4;break}var a=P(function(){var e=i.value.value;return e===0?0:!0===e?``:e||``}),o=P(function(){return!Array.isArray(a.value)&&!n(a.value)}),s=F(function(){if(this.N=_t,o.value){var t=a.value;e.__v&&e.__v.__e&&e.__v.__e.nodeType===3&&(e.__v.__e.data=t)}}),c=t.__$u.d;return t.__$u.d=function(){s(),c.call(this)},[o,a]},[]),o=a[0],s=a[1];return o.value?s.peek():s.value}ft.displayName=`ReactiveTextNode`,Object.defineProperties(M.prototype,{constructor:{configurable:!0,value:y(x,null).constructor},type:{configurable:!0,value:ft},props:{configurable:!0,get:function(){var e=this;return{data:{get value(){return e.value}}}}},__b:{configurable:!0,value:1}}),ut(`__b`,function(e,t){if(dt(),typeof t.type==`string`){var n,r=t.props;for(var i in r)if(i!==`children`){var a=r[i];a instanceof M&&(n||(t.__np=n={}),n[i]=a,r[i]=a.peek())}}e(t)}),ut(`__r`,function(e,t){if(e(t),t.type!==x){dt();var n,r=t.__c;r&&(r.__$f&=-2,(n=r.__$u)===void 0&&(r.__$u=n=function(e,t){var n;return F(function(){n=this},{name:t}),n.c=e,n}(function(e){return function(){var t;ct&&((t=this.y)==null||t.call(this)),e.__$f|=1,e.setState({})}}(r),typeof t.type==`function`?t.type.displayName||t.type.name:``))),dt(n)}}),ut(`__e`,function(e,t,n,r){dt(),e(t,n,r)}),ut(`diffed`,function(e,t){dt();var n;if(typeof t.type==`string`&&(n=t.__e)){var r=t.__np,i=t.props,a=n.U;if(a)for(var o in a){var s=a[o];s===void 0||r&&o in r||(s.d(),a[o]=void 0)}if(r)for(var c in a||(a={},n.U=a),r){var l=a[c],u=r[c];l===void 0?(l=pt(n,c,u,i),a[c]=l):l.o(u,i)}}e(t)});function pt(e,t,n,r){var i=t in e&&e.ownerSVGElement===void 0,a=N(n);return{o:function(e,t){a.value=e,r=t},d:F(function(){this.N=_t;var n=a.value.value;r[t]!==n&&(r[t]=n,i?e[t]=n:n!=null&&(!1!==n||t[4]===`-`)?e.setAttribute(t,n):e.removeAttribute(t))})}}ut(`unmount`,function(e,t){if(typeof t.type==`string`){var n=t.__e;if(n){var r=n.U;if(r)for(var i in n.U=void 0,r){var a=r[i];a&&a.d()}}var o=t.__np;if(o){var s=t.props;for(var c in o)s[c]=o[c]}t.__np=void 0}else{var l=t.__c;if(l){l.__$f|=8;var u=l.__$u;u&&(l.__$u=void 0,u.d())}}e(t)}),ut(`__h`,function(e,t,n,r){r<3&&(t.__$f|=2),e(t,n,r)}),S.prototype.shouldComponentUpdate=function(e,t){if(this.__R)return!0;var n=this.__$u,r=n&&n.s!==void 0;for(var i in t)return!0;if(this.__f||typeof this.u==`boolean`&&!0===this.u){var a=2&this.__$f;if(!(r||a||4&this.__$f)||1&this.__$f)return!0}else if(!(r||4&this.__$f)||3&this.__$f)return!0;for(var o in e)if(o!==`__source`&&e[o]!==this.props[o])return!0;for(var s in this.props)if(!(s in e))return!0;return!1};function mt(e,t){return je(function(){return N(e,t)},[])}var ht=function(e){queueMicrotask(function(){queueMicrotask(e)})};function gt(){Ve(function(){for(var e;e=lt.shift();)ot.call(e)})}function _t(){lt.push(this)===1&&(e.requestAnimationFrame||ht)(gt)}var vt=new URL(`worker.js`,import.meta.url).href,I=class extends Error{},yt=class extends I{constructor(e){super(`The file ${e} could not be fetched; check that the server of the page still runs.`)}},bt=class extends I{constructor(){super(`It was cancelled.`)}},xt=`assets/worker.js`,St=new Map;function Ct(e){if(!St.has(e)){let t=document.getElementById(e);St.set(e,t&&JSON.parse(t.textContent))}return St.get(e)}function wt(){return Ct(`files`)!==null}function Tt(e){return`?${Ct(`versions`)?.[e]??``}`}async function Et(e){let t=Ct(`files`);if(t===null){try{let t=await fetch(e+Tt(e));if(t.ok)return new Uint8Array(await t.arrayBuffer());if(t.status===404)return null}catch{}throw new yt(e)}let n=t[e];if(n===void 0)return null;let r=Uint8Array.from(atob(n),e=>e.charCodeAt(0)),i=new Blob([r]).stream().pipeThrough(new DecompressionStream(`gzip`));return new Uint8Array(await new Response(i).arrayBuffer())}async function Dt(){let e;if(wt()){let t=await Et(xt);e=new Worker(URL.createObjectURL(new Blob([t],{type:`text/javascript`})))}else e=new Worker(vt+Tt(xt),{type:`module`});let t=new Promise((t,n)=>{e.addEventListener(`error`,()=>n(new yt(xt)))});return{worker:e,broken:t}}function Ot(e,t){return Array.from({length:3},(n,r)=>e.subarray(r*t,(r+1)*t))}function kt(e){let t=e&32768?-1:1,n=e>>10&31,r=e&1023;return n===0?t*r*2**-24:n===31?r?NaN:t*(1/0):t*(1+r/1024)*2**(n-15)}function At(e){let t=Math.abs(e),n=Math.max(Math.floor(Math.log2(t)),-14),r=t*2**(10-n),i=Math.floor(r),a=r-i>.5||r-i===.5&&i%2==1,o=i+Number(a);return(e<0?32768:0)|o+(n+14<<10)}var jt=class extends I{name=`FileError`},Mt=`urushi`;function Nt(e){if(e.length<8)return null;let t=new DataView(e.buffer,e.byteOffset,e.byteLength),n=Number(t.getBigUint64(0,!0));if(n===0||8+n>e.length)return null;try{let{__metadata__:t,...r}=JSON.parse(new TextDecoder().decode(e.subarray(8,8+n)));return{description:Object(JSON.parse(t?.[Mt]??`{}`)),tensors:r,start:8+n}}catch{return null}}var Pt=33,Ft=20,It=2048;function Lt(e){let t=[],n=[],r=0;for(let[i,a]of Object.entries(e)){let e=new TextEncoder().encode(i),{length:o}=a,s=[...L(Ft),...L(It),...L(0),...L(0),...L(Pt),...zt(Vt(a)),...zt(o),...zt(o),...L(e.length)],c=[...zt(67324752),...s,...L(0),...e];t.push(Uint8Array.from(c),a);let l=[...zt(33639248),...L(Ft),...s,...Array(12).fill(0)];n.push(Uint8Array.from([...l,...zt(r),...e])),r+=c.length+o}let i=n.reduce((e,{length:t})=>e+t,0),a=L(n.length),o=[...zt(101010256),...[,,,,].fill(0),...a,...a];return Rt([...t,...n,Uint8Array.from([...o,...zt(i),...zt(r),...L(0)])])}function Rt(e){let t=new Uint8Array(e.reduce((e,{length:t})=>e+t,0)),n=0;for(let r of e)t.set(r,n),n+=r.length;return t}function L(e){return[e&255,e>>>8]}function zt(e){return[...L(e&65535),...L(e>>>16)]}var Bt=Uint32Array.from({length:256},(e,t)=>{let n=t;for(let e=0;e<8;e++)n=n>>>1^(n&1?3988292384:0);return n});function Vt(e){let t=4294967295;for(let n of e)t=t>>>8^Bt[(t^n)&255];return(t^4294967295)>>>0}var Ht=3;function Ut(e){return Nt(e)?.description.kind===`texture`}function Wt(e,{latentSize:t,fingerprint:n}){let r=Nt(e);if(r===null)throw Xt();let{description:i,tensors:a,start:o}=r;if(i.version!==Ht)throw new I(`It is a texture of another version of Urushi; save it again.`);if(i.weights!==n)throw new I(`It was made with other networks; save the texture again.`);let s=(t,n,r,i)=>{let s=a[t],c=r.reduce((e,t)=>e*t,i),[l,u]=s?.data_offsets??[0,0];if(s?.dtype!==n||String(s.shape)!==String(r)||u-l!==c||o+u>e.length)throw Xt();return e.slice(o+l,o+u)},c=Kt(i),l=qt(i,t),u=c.reduce((e,[t,n])=>e+t*n,0),d=e=>{let n=new Float32Array(s(e,`F32`,[t],4).buffer);if(!n.every(Number.isFinite))throw Xt();return n},[f,p]=[d(`lowest`),d(`step`)],m=l.high.map((e,t)=>Array.from({length:3},(n,r)=>{let i=l.channels===1?0:r,a=l.same[t]?0:l.shared+i*l.stride,o=e=>e<0?-1:a+e,s=l.low[t];return{lowest:f[t],step:p[t],high:o(e),low:o(s)}})),h=l.shared+l.channels*l.stride,g=m.flat().flatMap(({high:e,low:t})=>[e,t]);if(h>l.texelBytes||g.some(e=>e>=h))throw Xt();return{id:Vt(e).toString(16).padStart(8,`0`),file:e,levels:c,texels:s(`texels`,`U8`,[u,l.texelBytes],1),texelBytes:l.texelBytes,usedBytes:h,numbers:m,...Jt(i)}}function Gt(e){let{levels:t,texels:n,texelBytes:r,numbers:i}=e,[a,o]=t[0],s=t.length>1,c=n.length-r,l=s?n.subarray(c):n.subarray(0,a*o*r),u=new Float64Array(r);for(let e=0;e<l.length;e++)u[e%r]+=l[e];let d=u.map(e=>e*r/l.length),f=new Float32Array(3*i.length);return i.forEach((e,t)=>{e.forEach(({lowest:e,step:n,high:r,low:a},o)=>{let s=r<0?0:a<0?d[r]:256*d[r]+d[a];f[o*i.length+t]=e+n*s})}),f}function Kt({width:e,height:t,levels:n}){if(!Yt(e)||!Yt(t)||e*t===0)throw Xt();let r=[[e,t]];for(let[n,i]=[e,t];n>1||i>1;)[n,i]=[Math.max(n>>1,1),Math.max(i>>1,1)],r.push([n,i]);if(n!==1&&n!==r.length)throw Xt();return r.slice(0,n)}function qt(e,t){let n=Object(e.layout),{channels:r,shared:i,stride:a,texel_bytes:o}=n,{high:s,low:c,same:l}=n,u=e=>Array.isArray(e)&&e.length===t&&e.every(e=>Number.isInteger(e));if(!u(s)||!u(c)||!Array.isArray(l)||l.length!==t||![r,i,a,o].every(Yt))throw Xt();if(r!==1&&r!==3)throw new I(`It has other channels than red, green and blue.`);return{channels:r,shared:i,stride:a,texelBytes:o,high:s,low:c,same:l.map(Boolean)}}function Jt(e){let{to_texture:t,wrap:n,nearest:r}=Object(e.place),i=Array.isArray(t)?t.flat():[];if(!(i.length===6&&i.every(Number.isFinite))||n!==`repeat`&&n!==`mirror`&&n!==`clamp`)throw Xt();return{toTexture:i,wrap:n,nearest:r===!0}}function Yt(e){return Number.isSafeInteger(e)&&e>=0}function Xt(){return new I(`It is damaged or no texture that Urushi has saved.`)}function Zt(e,t){return[e[0]-t[0],e[1]-t[1],e[2]-t[2]]}function Qt(e,t){return e[0]*t[0]+e[1]*t[1]+e[2]*t[2]}function $t(e,t){return[e[1]*t[2]-e[2]*t[1],e[2]*t[0]-e[0]*t[2],e[0]*t[1]-e[1]*t[0]]}function en(e){let t=Math.hypot(...e)||1;return[e[0]/t,e[1]/t,e[2]/t]}var tn=33554432;function nn(e){let t=new TextDecoder(`latin1`).decode(e.subarray(0,4096)),n=/\n\n-Y (\d+) \+X (\d+)\n/.exec(t);if(!t.startsWith(`#?`)||n===null)throw new I(`This is no .hdr panorama that the page can read.`);let[r,i]=[Number(n[1]),Number(n[2])];rn(i,r);let a=new Float32Array(i*r*3),o=new Uint8Array(i*4),s=n.index+n[0].length;for(let t=0;t<r;t++){s=an(e,s,o,i);for(let e=0;e<i;e++){let n=o[4*e+3],r=n===0?0:2**(n-136);for(let n=0;n<3;n++)a[3*(t*i+e)+n]=o[4*e+n]*r}}return{width:i,height:r,pixels:a}}function rn(e,t){if(e*t>tn||e<2||t<1)throw new I(`This panorama is too large; up to 8192 by 4096 pixels can be read.`);if(Math.abs(e/t-2)>.05)throw new I(`This picture is no panorama, whose width is twice its height.`)}function an(e,t,n,r){let i=t;if(!(r>=8&&r<32768&&e[i]===2&&e[i+1]===2&&(e[i+2]<<8)+e[i+3]===r)){if(i+4*r>e.length)throw on();return n.set(e.subarray(i,i+4*r)),i+4*r}i+=4;for(let t=0;t<4;t++)for(let a=0;a<r;){let o=e[i++];if(o===void 0)throw on();let s=o>128,c=s?o-128:o;if(c===0||a+c>r||i+(s?1:c)>e.length)throw on();for(let r=0;r<c;r++)n[4*a+++t]=e[s?i:i+r];i+=s?1:c}return i}function on(){return new I(`This .hdr file is damaged or incomplete.`)}var sn=60,cn=Math.cos(5*Math.PI/180);function ln(e){let{width:t,height:n,pixels:r}=e,i=e=>(r[e]+r[e+1]+r[e+2])/3,a=0,o=0;for(let e=0;e<n;e++){let r=Math.sin(Math.PI*(e+.5)/n);for(let n=0;n<t;n++)a+=r*Math.min(i(3*(e*t+n)),1e4);o+=r*t}let s=sn*a/o,c=[],l=r.slice();for(let e=0;e<n;e++){let a=Math.PI*(e+.5)/n,o=2*Math.PI*Math.PI*Math.sin(a)/(t*n);for(let n=0;n<t;n++){let u=3*(e*t+n),d=i(u);if(d<=s)continue;let f=2*Math.PI*(n+.5)/t,p=[Math.sin(a)*Math.sin(f),Math.sin(a)*Math.cos(f),Math.cos(a)],m=c.find(e=>Qt(e.direction,p)>cn);if(m===void 0){if(c.length===4)continue;m={direction:p,power:[0,0,0],sum:[0,0,0]},c.push(m)}for(let e=0;e<3;e++){let t=r[u+e]*(1-s/d);m.power[e]+=t*o,m.sum[e]+=p[e]*d*o,l[u+e]-=t}let h=Math.hypot(...m.sum);m.direction=m.sum.map(e=>e/h)}}let u=c.map(({direction:e,power:t})=>({direction:[e[0],e[1],e[2]],power:[t[0],t[1],t[2]]}));return{panorama:{width:t,height:n,pixels:l},lights:u}}var R={AIR:1.000277,ETA_RANGE:[.5,3],MIN_ALPHA:.01,MIN_INDEX_STEP:9999e-7,TRAINED_G:[-.8,.9]},un={HALF_ANGLE_SHARE:.6666666666666666,MIN_TANGENT:.001,MAX_TANGENT:4,MAX_DIFFERENCE:1.5009831567151235,MIN_COSINE:.02},dn={FACTORS:5},fn={SHAPE:[96,32,8],MIN_LOG:-25,MAX_LOG:20,MIN_COSINE:.005},pn={DEEPEST:12};function mn(e,t,n){let r=1-n,i=r*r,a=i*i*r;return e*(1-a)+t*a}function hn(e,t,n){let r=e*e,i=1-r,a=(t-1)*(t+1)-n*n+r,o=Math.sqrt(a*a+t*t*4*(n*n)),s=Math.sqrt(.5*Math.max(o+a,0)),c=.5*Math.max(o-a,0),l=s-e,u=s+e,d=(l*l+c)/(u*u+c),f=s*e,p=c*r+1e-12,m=f-i,h=f+i,g=(m*m+p)/(h*h+p);return .5*d*(1+g)}function gn(e,t,n,r,i,a){let o=e+r,s=t+i,c=n+a;return Math.min(.5*Math.sqrt(o*o+s*s+c*c),1)}function _n(e,t,n,r,i,a){let o=Math.min(Math.max(n,0),1),s=Math.min(Math.max(t,0),.99),c=1.139+1.17*o,l=(c-Math.sqrt(c*c-.556*(1-o)))/.278,u=(1-l*l)/(1-r*l*l),d=1.3333333333333333*s/(1-s)/(1-u*r),f=Math.abs(.5*Math.log(Math.min(Math.max(e,1e-6),1)))+d;i[a]=d/Math.max(f,1e-6)*u,i[1+a]=f}function vn(e,t,n,r,i,a,o,s){let c=Math.max(i,0),l=Math.max(s,0),u=n+a,d=r+o,f=c+l,p=u*u+d*d,m=f*f,h=e*t,g=e/t,_=t/e,v=(p+m)/(u*u*_+d*d*g+h*m+1e-18),y=c+Math.sqrt(h*(n*n*g+r*r*_)+c*c),b=l+Math.sqrt(h*(a*a*g+o*o*_)+l*l);return h/3.141592653589793*(v*v)/(y*b)}function z(e){return typeof e==`number`?[e,e,e]:e}function yn(e){return e[0]===e[1]&&e[1]===e[2]?e[0]:e}function B(e,t){if(typeof e==`number`)return t(e);let[n,r,i]=z(e);return[t(n),t(r),t(i)]}function bn(e,t){let[n,r]=[z(e),z(t)];return yn([n[0]/r[0],n[1]/r[1],n[2]/r[2]])}function xn(e){if(`sigmaT`in e)return{albedo:e.albedo,sigmaT:e.sigmaT};let t=new Float64Array(6),[n,r,i,a]=[e.color,e.body,e.bodyColor,e.g].map(z);for(let e=0;e<3;e++)_n(n[e],r[e],i[e],a[e],t,2*e);let o=e=>yn([t[e],t[2+e],t[4+e]]);return{albedo:o(0),sigmaT:o(1)}}function Sn(e){if(`color`in e)return{color:e.color,body:e.body,bodyColor:e.bodyColor};let[t,n,r]=[z(e.albedo),z(e.sigmaT),z(e.g)],i=e=>yn([e(0),e(1),e(2)]);if(Math.max(...t)===0)return{color:i(e=>Math.exp(-2*n[e])),body:0,bodyColor:.8};let a=e=>n[e]*(1-t[e]*r[e]);return{color:1,body:i(e=>a(e)/(4/3+a(e))),bodyColor:i(e=>Tn(t[e],r[e]))}}function Cn(e,t){let n=e=>t*e/(1+(t-1)*e+1e-9),[r,i,a]=z(Sn(e).body);return[n(r),n(i),n(a)]}function wn(e,t,n=[1,1,1]){let{color:r,bodyColor:i}=Sn(e),[a,o,s]=[z(r),Cn(e,t),z(i)],c=e=>a[e]**t*((1-o[e])*n[e]+o[e]*s[e]);return[c(0),c(1),c(2)]}function Tn(e,t){let n=Math.sqrt((1-e)/(1-e*t));return(1-n)*(1-.139*n)/(1+1.17*n)}var En={alpha:.1,ior:1.5,color:1,body:0,bodyColor:.8,g:0};function Dn(e,t){let{coats:n}=e,r=n.slice(0,n.indexOf(t)).filter(t=>kn(e,t)).at(-1)?.ior??R.AIR;return z(Fn(t.ior,r)).some(e=>e!==1)}function On(e){if(`reflectance`in e)return z(e.reflectance);if(`r0`in e)return z(e.r0);if(e.kind===`codes`||e.kind===`texels`)return[.5,.5,.5];let[t,n]=`k`in e?[z(e.eta),z(e.k)]:[z(e.ior),[0,0,0]],r=e=>Number((1-4*t[e]/((t[e]+1)**2+n[e]**2)).toFixed(3));return[r(0),r(1),r(2)]}function kn(e,t){return e.solo===null?t.on:e.solo===t.id}function An(e){let{bottom:t,coats:n}=e;if(t.kind===`texels`)throw new I(`A texture of codes can be saved as a material file or a Mitsuba scene.`);return{bottom:t,coats:n.filter(t=>kn(e,t))}}function jn(e){let{bottom:t,coats:n}=An(e),r=R.AIR,i=n.map(e=>{let{alpha:t,alphaV:n,ior:i,g:a,thickness:o=1}=e,s=Fn(i,r);r=i;let{albedo:c,sigmaT:l}=xn(e);return{...n===void 0?{alpha:t}:{alpha:t,alphaV:n},eta:s,albedo:c,sigmaT:B(l,e=>e*o),g:a}}),a=Mn(t,bn(r,R.AIR));return{bottom:a.kind===`dielectric`?Nn(a):a,coats:i,energyCompensation:e.energyCompensation===!0}}function Mn(e,t){return e.kind===`codes`?{...e,latents:Pn(e.latents,t)}:e.kind===`dielectric`?{...e,ior:bn(e.ior,t)}:`k`in e?{...e,eta:bn(e.eta,t),k:bn(e.k,t)}:e}function Nn({ior:e,...t}){return{...t,eta:Fn(e,R.AIR)}}function Pn(e,t){let n=e.length/3;return e.map((r,i)=>{let a=i%n===4||i%n===5,o=Math.floor(i/n);return a&&e[o*n+5]>0?r/z(t)[o]:r})}function Fn(e,t){let[n,r]=R.ETA_RANGE;return B(bn(e,t),e=>Math.abs(e-1)<R.MIN_INDEX_STEP?1:Math.min(Math.max(e,n),r))}function In(e){if(!(`alpha`in e)||e.alphaV===void 0)return 1;let t=z(e.alphaV),n=z(e.alpha).map((e,n)=>e/t[n]);return Math.max(...n,...n.map(e=>1/e))}function Ln({bottom:e,coats:t}){return e.kind===`codes`&&e.widths===2||[e,...t].some(e=>`alphaV`in e)}function Rn({bottom:e,coats:t}){return e.kind===`codes`&&e.widths===2||[e,...t].some(e=>In(e)!==1)}function zn({bottom:e,coats:t}){return e.kind!==`texels`&&t.length<6}function Bn(e){return Math.max(0,...e.coats.map(e=>e.id))+1}function Vn(e,t,n){let r=[...e.coats],[i]=r.splice(t,1);return i===void 0?e:(r.splice(Math.max(0,Math.min(n,r.length)),0,i),{...e,coats:r})}function Hn(e){if(!zn(e))return e;let{coats:t}=e,{ior:n,alpha:r,alphaV:i}=t[0]??En,a={ior:n,alpha:r,...i===void 0?{}:{alphaV:i}},o={...En,...a,id:Bn(e),on:!0};return{...e,coats:[o,...t]}}function Un(e,t){return{...e,coats:e.coats.filter(e=>e.id!==t),solo:e.solo===t?null:e.solo}}var Wn={label:`Roughness α`,hint:`GGX width of the surface: 0.01 is a polished mirror, 1 is matt.`,low:.01,high:1,power:2,fallback:.1},Gn={alpha:{...Wn,label:`Roughness αᵤ`,hint:`GGX width along the tangent, the direction of brushing or turning.`},alphaV:{...Wn,label:`Roughness αᵥ`,hint:`GGX width across the tangent.`}},Kn={label:`Tangent angle`,hint:`Angle by which the tangent of all layers is turned about the normal, in degrees.`,low:-90,high:90,power:1,fallback:0},qn={low:0,high:1,power:1},Jn={alpha:Wn,color:{label:`Colour`,hint:`Colour of a clear dye: what light keeps that passes the coat twice, at thickness 1.`,...qn,fallback:1,isColour:!0},body:{label:`Body`,hint:`How opaque the pigment is, at thickness 1: 0 is clear, 1 is opaque paint.`,...qn,fallback:0},bodyColor:{label:`Body colour`,hint:`Colour of an opaque layer of the pigment.`,...qn,fallback:.8,isColour:!0},thickness:{label:`Thickness`,hint:`Factor of the medium's depth.`,low:0,high:100,slide:4,power:2,fallback:1},ior:{label:`Index n`,hint:`Index of refraction: water 1.33, varnish 1.5. Between equal indices there is no surface.`,low:.51,high:3,power:1,fallback:1.5},sigmaT:{label:`Depth σₜ`,hint:`Optical depth of the medium: how often light is absorbed or scattered on its way.`,low:0,high:1e3,slide:10,power:3,fallback:0},albedo:{label:`Scattering`,hint:`Single-scattering albedo of the medium: 0 only absorbs, 1 only scatters.`,...qn,fallback:0},g:{label:`Direction g`,hint:`Asymmetry of the scattering: above 0 forwards, below 0 backwards.`,low:-.99,high:.99,power:1,fallback:0}},Yn={alpha:{...Wn,fallback:.2},r0:{label:`Reflectance`,hint:`Reflectance at normal incidence.`,...qn,fallback:.9,isColour:!0},eta:{label:`Index n`,hint:`Real part of the index of refraction.`,low:0,high:10,slide:6,power:2,fallback:1.5},k:{label:`Extinction k`,hint:`Imaginary part of the index of refraction.`,low:0,high:20,slide:10,power:1,fallback:3},reflectance:{label:`Reflectance`,hint:`Reflectance of the matt surface.`,...qn,fallback:.5,isColour:!0}};function Xn({low:e,high:t},n){return Math.min(Math.max(n,e),t)}function Zn(e,t){let n=(e.slide??e.high)-e.low;return Math.min(Math.max((t-e.low)/n,0),1)**(1/e.power)}function Qn(e,t){let n=(e.slide??e.high)-e.low;return Xn(e,$n(e.low+n*t**e.power))}function $n(e){let t=Math.abs(e)>=.1||e===0?3:4;return Number(e.toFixed(t))}var er=[{name:`Black urushi`,bottom:{kind:`diffuse`,reflectance:[.012,.01,.01]},coats:[{alpha:.02,ior:1.53,g:0,color:[.85,.65,.45],body:0,bodyColor:.8}]},{name:`Vermilion urushi`,bottom:{kind:`diffuse`,reflectance:[.012,.01,.01]},coats:[{alpha:.02,ior:1.53,g:0,color:[.85,.65,.45],body:0,bodyColor:.8},{alpha:.05,ior:1.53,g:0,color:1,body:1,bodyColor:[.62,.055,.02]}]},{name:`Shellac on maple`,bottom:{kind:`diffuse`,reflectance:[.62,.44,.27]},coats:[{alpha:.05,ior:1.516,g:0,color:[.95,.8,.52],body:0,bodyColor:.8}]},{name:`Spirit varnish on spruce`,bottom:{kind:`diffuse`,reflectance:[.58,.4,.22]},coats:[{alpha:.04,ior:1.52,g:0,color:[.86,.42,.12],body:0,bodyColor:.8}]},{name:`Oil on walnut`,bottom:{kind:`diffuse`,reflectance:[.2,.105,.052]},coats:[{alpha:.3,ior:1.48,g:0,color:[.97,.9,.74],body:0,bodyColor:.8}],energyCompensation:!0},{name:`Polyurethane on oak`,bottom:{kind:`diffuse`,reflectance:[.4,.27,.15]},coats:[{alpha:.12,ior:1.5,g:0,color:[.97,.92,.8],body:0,bodyColor:.8}],energyCompensation:!0},{name:`French polish on mahogany`,bottom:{kind:`diffuse`,reflectance:[.26,.085,.042]},coats:[{alpha:.015,ior:1.516,g:0,color:1,body:0,bodyColor:.8},{alpha:.05,ior:1.516,g:0,color:[.9,.66,.4],body:0,bodyColor:.8}]},{name:`Solid white car paint`,bottom:{kind:`diffuse`,reflectance:.3},coats:[{alpha:.015,ior:1.5,g:0,color:1,body:0,bodyColor:.8},{alpha:.1,ior:1.5,g:0,color:1,body:1,bodyColor:.86}]},{name:`Metallic red car paint`,bottom:{kind:`conductor`,alpha:.33,eta:[1.658,.88,.521],k:[9.224,6.27,4.837]},coats:[{alpha:.015,ior:1.5,g:0,color:1,body:0,bodyColor:.8},{alpha:.1,ior:1.5,g:0,color:[.7,.05,.03],body:.04,bodyColor:[.6,.04,.03]}]},{name:`Candy blue car paint`,bottom:{kind:`conductor`,alpha:.22,eta:[1.658,.88,.521],k:[9.224,6.27,4.837]},coats:[{alpha:.015,ior:1.5,g:0,color:1,body:0,bodyColor:.8},{alpha:.1,ior:1.5,g:0,color:[.04,.16,.72],body:0,bodyColor:.8}]},{name:`White enamel`,bottom:{kind:`conductor`,alpha:.3,r0:[.53,.51,.5]},coats:[{alpha:.025,ior:1.55,g:0,color:1,body:1,bodyColor:[.86,.85,.82],thickness:2}]},{name:`Blue enamel on copper`,bottom:{kind:`conductor`,alpha:.15,eta:[.201,.924,1.102],k:[3.913,2.453,2.142]},coats:[{alpha:.025,ior:1.55,g:0,color:[.05,.18,.62],body:0,bodyColor:.8}]},{name:`Green enamel on silver`,bottom:{kind:`conductor`,alpha:.12,eta:[.155,.117,.138],k:[4.828,3.122,2.147]},coats:[{alpha:.025,ior:1.55,g:0,color:[.08,.52,.2],body:0,bodyColor:.8}]},{name:`Celadon`,bottom:{kind:`diffuse`,reflectance:[.66,.66,.62]},coats:[{alpha:.04,ior:1.52,g:0,color:[.58,.83,.7],body:.12,bodyColor:[.8,.88,.82]}]},{name:`Tenmoku`,bottom:{kind:`diffuse`,reflectance:[.17,.075,.035]},coats:[{alpha:.04,ior:1.56,g:0,color:[.2,.06,.02],body:0,bodyColor:.8}]},{name:`Honey glaze`,bottom:{kind:`diffuse`,reflectance:[.75,.7,.62]},coats:[{alpha:.03,ior:1.52,g:0,color:[.8,.52,.22],body:0,bodyColor:.8}]},{name:`Lacquered brass`,bottom:{kind:`conductor`,alpha:.12,eta:[.446,.538,1.02],k:[3.52,2.72,1.91]},coats:[{alpha:.06,ior:1.49,g:0,color:[.98,.94,.84],body:0,bodyColor:.8}]},{name:`Gilding under shellac`,bottom:{kind:`conductor`,alpha:.2,eta:[.143,.375,1.442],k:[3.983,2.386,1.603]},coats:[{alpha:.05,ior:1.516,g:0,color:[.97,.86,.62],body:0,bodyColor:.8}]},{name:`Anodised aluminium`,bottom:{kind:`conductor`,alpha:.25,eta:[1.658,.88,.521],k:[9.224,6.27,4.837]},coats:[{alpha:.2,ior:1.65,g:0,color:[.1,.3,.66],body:0,bodyColor:.8}],energyCompensation:!0},{name:`Tarnished silver`,bottom:{kind:`conductor`,alpha:.15,eta:[.155,.117,.138],k:[4.828,3.122,2.147]},coats:[{alpha:.2,ior:2.2,g:0,color:[.6,.45,.24],body:.05,bodyColor:[.1,.08,.06]}],energyCompensation:!0},{name:`Red nail lacquer`,bottom:{kind:`diffuse`,reflectance:[.72,.5,.42]},coats:[{alpha:.02,ior:1.48,g:0,color:1,body:.9,bodyColor:[.55,.02,.04]}]},{name:`Sheer pink nail lacquer`,bottom:{kind:`diffuse`,reflectance:[.72,.5,.42]},coats:[{alpha:.02,ior:1.48,g:0,color:[.98,.72,.74],body:.1,bodyColor:[.9,.6,.62]}]},{name:`Brushed chromium`,bottom:{kind:`conductor`,alpha:.06,alphaV:.3,eta:[4.37,2.917,1.655],k:[5.207,4.231,3.755]},coats:[]},{name:`Brushed copper under lacquer`,bottom:{kind:`conductor`,alpha:.06,alphaV:.3,eta:[.201,.924,1.102],k:[3.913,2.453,2.142]},coats:[{alpha:.03,ior:1.49,g:0,color:1,body:0,bodyColor:.8}]}],tr={Gold:{eta:[.143,.375,1.442],k:[3.983,2.386,1.603]},Silver:{eta:[.155,.117,.138],k:[4.828,3.122,2.147]},Copper:{eta:[.201,.924,1.102],k:[3.913,2.453,2.142]},Aluminium:{eta:[1.658,.88,.521],k:[9.224,6.27,4.837]},Chromium:{eta:[4.37,2.917,1.655],k:[5.207,4.231,3.755]},Tungsten:{eta:[4.371,3.3,2.998],k:[3.501,2.605,2.273]}},nr=er.map(({coats:e,...t})=>({...t,coats:e.map((e,t)=>({...e,id:t+1,on:!0})),solo:null}));function rr(e){let t=nr.find(({name:t})=>t===e.name),n=({solo:e,...t})=>JSON.stringify(Object.entries(t).filter(([,e])=>e!==!1).sort());return t!==void 0&&n(t)!==n(e)?`${e.name} (modified)`:e.name}function ir(e){return nr.find(t=>t.name===e)}var ar=[`goblet`,`ball`,`caddy`,`teapot`,`plate`,`vase`,`bowl`,`sheet`],or=[`studio`,`sky`,`room`,`own`],sr=[`neutral`,`filmic`,`none`],cr=[`off`,`side`,`swipe`,`difference`],lr=[2,10,50],V={materials:[ir(`Vermilion urushi`),ir(`Gilding under shellac`)],active:0,comparison:`off`,edge:.5,scale:50,object:`goblet`,mesh:``,environment:`studio`,panorama:``,rotation:0,exposure:0,tone:`neutral`,background:`environment`,view:{azimuth:20,elevation:18,zoom:1,fov:24,pan:[0,0]},turntable:!1,plots:!0,incidence:45};function ur(e){return e.materials[e.active]}function dr(e,t){let[n,r]=e.materials;return{...e,materials:e.active===0?[t,r]:[n,t]}}var fr=`Indices of refraction were relative to the medium above when this was saved; they have been converted to absolute ones, at most 3.`;function pr(e,t){let n=xr(e,`the state`),r=n.materials;if(!Array.isArray(r)||r.length<1||r.length>2)throw new I(`The state has no materials.`);let i=mr(r[0],t),a=r.length>1?mr(r[1],t):V.materials[1],o=xr(n.view??{},`the view`),s=Array.isArray(o.pan)?o.pan:[],{background:c}=n;return{materials:[i,a],active:+(n.active===1),comparison:Tr(n.comparison,cr,V.comparison),edge:H(n.edge,0,1,V.edge),scale:Tr(n.scale,lr,V.scale),object:Tr(n.object,[...ar,`own`],V.object),mesh:wr(n.mesh,V.mesh),environment:Tr(n.environment,or,V.environment),panorama:wr(n.panorama,V.panorama),rotation:H(n.rotation,-180,180,V.rotation),exposure:H(n.exposure,-6,6,V.exposure),view:{azimuth:H(o.azimuth,-180,180,V.view.azimuth),elevation:H(o.elevation,-10,85,V.view.elevation),zoom:H(o.zoom,.5,4,V.view.zoom),fov:H(o.fov,5,60,V.view.fov),pan:[H(s[0],-2,2,0),H(s[1],-2,2,0)]},tone:Tr(n.tone,sr,V.tone),background:c===`transparent`||/^#[0-9a-f]{6}$/.test(String(c))?String(c):V.background,turntable:n.turntable===!0,plots:n.plots!==!1,incidence:H(n.incidence,0,89,V.incidence)}}function mr(e,t){let n=xr(e,`the material`),r=n.coats??[];if(!Array.isArray(r)||r.length>6)throw new I(`A material has at most 6 coats.`);let i=r.map(_r),a=vr(n.bottom);if(a.kind===`texels`&&r.length>0)throw new I(`A texture of codes cannot be coated on this page.`);if(a.kind!==`texels`&&[n.bottom,...r].some(hr)){t?.(fr);let e=1;for(let t of i)t.ior=B(bn(t.ior,e),e=>Xn(Jn.ior,e)),t.on&&(e=bn(R.AIR,t.ior));a=Mn(a,e)}let o=n.solo;return{name:wr(n.name,`Material`),bottom:a,coats:i,...n.energyCompensation===!0?{energyCompensation:!0}:{},...n.rotation===void 0?{}:{rotation:H(n.rotation,-180,180,0)},solo:typeof o==`number`&&Number.isInteger(o)&&o>=0&&o<=r.length?o:null}}function hr({kind:e,eta:t}){return t!==void 0&&e!==`conductor`}function gr(e){let{ior:t}=Jn;return hr(e)?B(Sr(e.eta,t,`eta`),e=>e*R.AIR):Sr(e.ior,t,`ior`)}function _r(e,t){let n=xr(e,`a coat`),r=e=>Sr(n[e],Jn[e],e),i=[`albedo`,`sigmaT`].some(e=>e in n)?{albedo:r(`albedo`),sigmaT:r(`sigmaT`)}:{color:r(`color`),body:r(`body`),bodyColor:r(`bodyColor`)},a=z(r(`thickness`))[0];return{id:t+1,on:n.on!==!1,...br(n,r(`alpha`)),ior:gr(n),...i,g:r(`g`),...a===1?{}:{thickness:a}}}function vr(e){let t=xr(e,`the bottom`),n=e=>Sr(t[e],Yn[e],e);switch(t.kind){case`conductor`:return`r0`in t?{kind:`conductor`,...br(t,n(`alpha`)),r0:n(`r0`)}:{kind:`conductor`,...br(t,n(`alpha`)),eta:n(`eta`),k:n(`k`)};case`dielectric`:return{kind:`dielectric`,...br(t,n(`alpha`)),ior:gr(t)};case`diffuse`:return{kind:`diffuse`,reflectance:n(`reflectance`)};case`codes`:return{kind:`codes`,latents:Cr(t.latents),...t.widths===2?{widths:2}:{},...t.table===void 0?{}:{table:yr(t.table,`table`)},...t.besideLobe===!0?{besideLobe:!0}:{}};case`texels`:return{kind:`texels`,texture:yr(t.texture,`texture`)};default:throw new I(`The bottom is of no kind that this page knows.`)}}function yr(e,t){if(typeof e!=`string`||!/^[0-9a-f]{8}$/.test(e))throw new I(`The name of the bottom's ${t} is damaged.`);return e}function br(e,t){let n=e.alphaV;return n===void 0?{alpha:t}:{alpha:t,alphaV:Sr(n,Jn.alpha,`alphaV`)}}function xr(e,t){if(typeof e!=`object`||!e||Array.isArray(e))throw new I(`There is no description of ${t}.`);return e}function Sr(e,t,n){if(e===void 0)return t.fallback;let r=Array.isArray(e)?e:[e];if(r.length!==1&&r.length!==3||!r.every(e=>typeof e==`number`&&Number.isFinite(e)))throw new I(`The parameter ${n} is neither a number nor three.`);return B(r.length===1?r[0]:e,e=>Xn(t,e))}function Cr(e){if(!(Array.isArray(e)&&e.length>0&&e.length<=768)||e.length%3||!e.every(e=>typeof e==`number`&&Number.isFinite(e)))throw new I(`The codes of the bottom are damaged.`);return new Float32Array(e)}function H(e,t,n,r){return typeof e!=`number`||!Number.isFinite(e)?r:Math.min(Math.max(e,t),n)}function wr(e,t){return typeof e==`string`?e.slice(0,80):t}function Tr(e,t,n){return t.find(t=>t===e)??n}var Er=700,Dr=class{past=[];future=[];kind=``;time=-1/0;record(e,t,n){t!==``&&t===this.kind&&n-this.time<Er||this.past.push(e),this.past.length>200&&this.past.shift(),this.future=[],this.kind=t,this.time=n}undo(e){return this.step(this.past,this.future,e)}redo(e){return this.step(this.future,this.past,e)}get canUndo(){return this.past.length>0}get canRedo(){return this.future.length>0}step(e,t,n){let r=e.pop();return r===void 0?null:(t.push(n),this.kind=``,r)}},U=N(V),W=P(()=>ur(U.value)),Or=N(null),kr=N(null);async function Ar(e,t){if(kr.value!==null)throw new I(`Something else is being done; wait until it has ended, or cancel it.`);let n=new AbortController,r=t=>{kr.value={text:e,share:t,cancel:()=>n.abort()}};r(),Nr(e);try{return await t(n.signal,e=>{n.signal.aborted||r(e)})}finally{kr.value=null}}var jr=N(``),Mr=0;function Nr(e){jr.value=e,clearTimeout(Mr),Mr=setTimeout(()=>{jr.value=``},4e3)}var Pr=new Dr,Fr=N(0),Ir=P(()=>Fr.value>=0&&Pr.canUndo),Lr=P(()=>Fr.value>=0&&Pr.canRedo);function Rr(e,t=``){e!==U.value&&(Pr.record(U.value,t,performance.now()),U.value=e,Fr.value++)}function G(e,t=``){Rr(dr(U.value,e),t)}function K(e){U.value={...U.value,...e}}function zr(){Vr(Pr.undo(U.value),`Undone`)}function Br(){Vr(Pr.redo(U.value),`Redone`)}function Vr(e,t){if(e===null)return;let{view:n,turntable:r,plots:i,edge:a,scale:o,incidence:s}=U.value;U.value={...e,view:n,turntable:r,plots:i,edge:a,scale:o,incidence:s},Nr(t),Fr.value++}function q(e,t,n=``){e instanceof bt?Nr(n+e.message):e instanceof I?Or.value={text:n+e.message,retry:e instanceof yt?t:void 0}:(console.error(e),Or.value={text:`${n}Something went wrong (${e}); load the page anew.`})}function Hr(e){Or.value={text:e}}function Ur(e,t){try{t?Rr(e()):U.value=e()}catch(e){q(e)}}var Wr=class e{capacity;widths;directions;cosD;constructor(e,t=1){this.capacity=e,this.widths=t,this.directions=new Float64Array(6*e),this.cosD=new Float64Array(e)}static of(t,n,r=1){let i=new e(t.length/3,r);for(let e=0;e<i.capacity;e++){let r=3*e;i.set(e,t[r],t[r+1],t[r+2],n[r],n[r+1],n[r+2])}return i}set(e,t,n,r,i,a,o){let{directions:s}=this,c=6*e;s[c]=t,s[c+1]=n,s[c+2]=r,s[c+3]=i,s[c+4]=a,s[c+5]=o,this.cosD[e]=gn(t,n,r,i,a,o)}},Gr=fn.SHAPE.reduce((e,t)=>e*t,1)*3;1+dn.FACTORS;var Kr={glsl:{title:`GLSL`,suffix:`.glsl`},wgsl:{title:`WGSL`,suffix:`.wgsl`},hlsl:{title:`HLSL`,suffix:`.hlsl`},slang:{title:`Slang`,suffix:`.slang`},osl:{title:`OSL`,suffix:`.osl`},python:{title:`NumPy`,suffix:`-numpy.py`}},qr=[`red`,`green`,`blue`];async function Jr(e,t=1){let n=`shaders/${t===1?``:`anisotropic/`}${e}.txt`,r=await Et(n);if(r===null)throw new I(`The shader code is missing beside the page (${n}).`);return new TextDecoder().decode(r)}function Yr(e,{latents:t},n=0){let r=t.length/3,i=n*Math.PI/180;return Zr(e,(e,n)=>$r(t[n*r+e])).replace(/\bcode_tangent_x\b/,$r(Math.fround(Math.cos(i)))).replace(/\bcode_tangent_y\b/,$r(Math.fround(Math.sin(i))))}function Xr(e,{numbers:t}){return Zr(e,(e,n)=>Qr(t[e][n]))}function Zr(e,t){return e.replace(/\bcode_(\d+)_(red|green|blue)\b/g,(e,n,r)=>t(Number(n),qr.indexOf(r)))}function Qr({lowest:e,step:t,high:n,low:r}){let i=(e,t)=>` + stored[${e}] * ${$r(t)}`,a=$r(e);return n<0?a:r<0?a+i(n,255*t):a+i(n,65280*t)+i(r,255*t)}function $r(e){for(let t=1;t<9;t++){let n=Number(e.toPrecision(t));if(Math.fround(n)===Math.fround(e))return ei(n)}return ei(Number(e.toPrecision(9)))}function ei(e){let t=String(e);return/^-?\d+$/.test(t)?`${t}.0`:t}var ti=N(new Map);async function ni(e,t){let n=Wt(e,t),r={texture:n,shader:Xr(await Jr(`glsl`),n),basis:await t.basisTexels()};return ti.value=new Map(ti.value).set(n.id,r),n.id}var ri=N(new Map);function ii(e){let t=Vt(new Uint8Array(ai(e).buffer)).toString(16).padStart(8,`0`);return ri.value=new Map(ri.value).set(t,e),t}function ai(e){let t=new DataView(new ArrayBuffer(2*e.length));return e.forEach((e,n)=>{t.setUint16(2*n,At(e),!0)}),t}function oi(e){let t=new DataView(e.buffer,e.byteOffset,e.byteLength),n=2*Gr/e.length;if(n!==1&&n!==3)throw si();let r=Float32Array.from({length:Gr},(e,r)=>kt(t.getUint16(2*Math.floor(r/n),!0)));if(!r.every(Number.isFinite))throw si();return r}function si(){return new I(`The table of the material is damaged.`)}var ci=3;function li(e){return di(e).description.weights}function ui(e,{latentSize:t,widths:n,fingerprint:r}){let{description:i,tensors:a,start:o}=di(e);if(i.weights!==r)throw mi();let s={kind:`codes`,latents:(()=>{let n=a.latents;if(n===void 0)throw hi();let[r,i]=n.data_offsets??[0,0],[s,c]=n.shape??[];if(n.dtype!==`F32`||s!==3&&s!==1||o+i>e.length||c!==t||i-r!==4*s*c)throw hi();let l=new Float32Array(e.slice(o+r,o+i).buffer);if(!l.every(Number.isFinite))throw hi();return s===3?l:new Float32Array([...l,...l,...l])})()};if(n===1){let{data_offsets:[t,n]=[0,0],dtype:r}=a.table??{};if(t===n)return{bottom:s};if(r!==`F16`||o+n>e.length)throw hi();let c=ii(oi(e.slice(o+t,o+n)));return{bottom:{...s,table:c,besideLobe:i.beside_lobe===!0}}}let{rotation:c=0}=i;if(typeof c!=`number`||!Number.isFinite(c))throw hi();return{bottom:{...s,widths:n},rotation:fi(c)}}function di(e){let t=Nt(e);if(t===null)throw hi();if(t.description.kind!==`material`)throw new I(`It is no material that Urushi has saved.`);return t}function fi(e){return((e+180)%360+360)%360-180}function pi({latents:e,table:t},{latentSize:n,widths:r,fingerprint:i},a=0){let o=t?.isOfCodes?void 0:t,s=r===2&&a!==0?{rotation:a}:{},c=o===void 0?{}:{beside_lobe:o.besideLobe},l={kind:`material`,version:ci,weights:i,...s,...c},u=e.byteLength,d=u+2*(o?.logs.length??0),f={__metadata__:{urushi:JSON.stringify(l)},latents:{dtype:`F32`,shape:[3,n],data_offsets:[0,u]}};o!==void 0&&(f.table={dtype:`F16`,shape:[...fn.SHAPE,3],data_offsets:[u,d]});let p=JSON.stringify(f),m=new TextEncoder().encode(p.padEnd(Math.ceil(p.length/8)*8)),h=new Uint8Array(8+m.length+d),g=new DataView(h.buffer);return g.setBigUint64(0,BigInt(m.length),!0),h.set(m,8),e.forEach((e,t)=>{g.setFloat32(8+m.length+4*t,e,!0)}),o!==void 0&&h.set(new Uint8Array(ai(o.logs).buffer),8+m.length+u),h}function mi(){return new I(`It was made with other networks; encode the material again.`)}function hi(){return new I(`It is damaged or no material that Urushi has saved.`)}var gi=1/7;function _i(e){let{inputs:t,lost:n}=vi(e),r=[`<?xml version="1.0"?>`,`<materialx version="1.39" colorspace="lin_rec709">`,`  <open_pbr_surface name="surface" type="surfaceshader">`,...Object.entries(t).map(([e,t])=>{let[n,r]=typeof t==`number`?[`float`,t]:[`color3`,t.join(`, `)];return`    <input name="${e}" type="${n}" value="${r}" />`}),`  </open_pbr_surface>`,`  <surfacematerial name="material" type="material">`,`    <input name="surfaceshader" type="surfaceshader" nodename="surface" />`,`  </surfacematerial>`,`</materialx>`,``].join(`
`),i=`The document leaves out what OpenPBR does not have: ${n.join(`, `)}.`;return{text:r,lost:n.length>0?i:``}}function vi(e){let{bottom:t,coats:n}=An(e),r=[],i=t=>`coat ${e.coats.length-e.coats.indexOf(t)}`,[a,...o]=n,s=n.some(e=>Math.min(...Cn(e,yi(e)))>=.5),c=Mn(t,bn(n.at(-1)?.ior??R.AIR,R.AIR)),l=o.filter(t=>Dn(e,t)),u;if(c.kind===`diffuse`||s&&c.kind!==`codes`){let e=n.reduceRight((e,t)=>wn(t===a?{...Sn(t),color:1,g:0}:t,yi(t),e),On(c)),t=l.shift();u=t?Si(t,e,a.ior,r):bi({kind:`diffuse`,reflectance:e},r)}else{u=bi(c,r);let e=o.reduce((e,t)=>wn({...Sn(t),body:0,g:0},yi(t),e),[1,1,1]),t=u.base_color;t?u.base_color=[0,1,2].map(n=>t[n]*e[n]):e.some(e=>e!==1)&&r.push(`the colour of the lower coats`);for(let e of n)Ei(Sn(e).body)>0&&r.push(`the body of ${i(e)} and its colour`)}if(r.push(...l.map(e=>`the surface of ${i(e)}`)),a!==void 0){let e=wi(a,`the coat's roughness of each channel`,r);Object.assign(u,{coat_weight:1,coat_color:z(B(Sn(a).color,e=>e**yi(a))),coat_roughness:e.roughness,coat_roughness_anisotropy:e.anisotropy,coat_ior:Ti(a.ior,`the coat's index of each channel`,r)})}return Rn({bottom:t,coats:n})&&(e.rotation??0)!==0&&r.push(`the tangent's angle`),{inputs:u,lost:r}}function yi({thickness:e=1}){return e}function bi(e,t){switch(e.kind){case`diffuse`:return{base_color:z(e.reflectance),specular_weight:0};case`dielectric`:{let{roughness:n}=wi(e,`the bottom's roughness of each channel`,t);return{base_weight:0,specular_roughness:n,specular_ior:Ti(e.ior,`the bottom's index of each channel`,t)}}case`codes`:throw new I(`A loaded material cannot be written as MaterialX; save the material, or its code.`)}let n=wi(e,`the bottom's roughness of each channel`,t);return{...xi(e),base_metalness:1,specular_roughness:n.roughness,specular_roughness_anisotropy:n.anisotropy}}function xi(e){if(`r0`in e)return{base_color:z(e.r0)};let[t,n]=[z(e.eta),z(e.k)],r=e=>z(yn([e(0),e(1),e(2)])),i=r(e=>hn(1,t[e],n[e]));return{base_color:i,specular_color:r(e=>Math.min(hn(gi,t[e],n[e])/mn(i[e],1,gi),1))}}function Si(e,t,n,r){let i=wi(e,`the bottom's roughness of each channel`,r),a=Ti(e.ior,`the bottom's index of each channel`,r),o=Ci(a/Ei(n));return{base_color:z(B(t,e=>(1-o)*e/(1-e*o))),specular_weight:1,specular_roughness:i.roughness,specular_roughness_anisotropy:i.anisotropy,specular_ior:a}}function Ci(e){return e<=1?0:1-(1-(e-1)/(4.08567+1.00071*e))/(e*e)}function wi({alpha:e,alphaV:t},n,r){let[i,a]=[Ti(e,n,r),Ei(t??e)];a>i&&r.push(`a width across the tangent above that along it`);let o=Math.min(a/i,1),s=a>i?Math.sqrt(i*a):i,c=Math.sqrt(2/(1+o*o));return{roughness:Di(Math.sqrt(s/c)),anisotropy:Di(1-o)}}function Ti(e,t,n){return new Set(z(e)).size>1&&!n.includes(t)&&n.push(t),Ei(e)}function Ei(e){let[t,n,r]=z(e);return t===n&&n===r?t:(t+n+r)/3}function Di(e){return Number(e.toFixed(6))}var Oi=`urushi convert writes it as a Mitsuba scene.`,ki=`open_pbr_surface`,Ai={base_weight:1,base_color:.8,base_metalness:0,specular_weight:1,specular_color:1,specular_roughness:.3,specular_ior:1.5,specular_roughness_anisotropy:0,coat_weight:0,coat_color:1,coat_roughness:0,coat_roughness_anisotropy:0,coat_ior:1.6},ji={base_weight:[`base`,1],base_metalness:[`metalness`,0],specular_weight:[`specular`,1],specular_roughness:[`specular_roughness`,.2],specular_ior:[`specular_IOR`,1.5],specular_roughness_anisotropy:[`specular_anisotropy`,0],coat_weight:[`coat`,0],coat_roughness:[`coat_roughness`,.1],coat_roughness_anisotropy:[`coat_anisotropy`,0],coat_ior:[`coat_IOR`,1.5]},Mi={base_diffuse_roughness:0,transmission_weight:0,subsurface_weight:0,fuzz_weight:0,thin_film_weight:0,emission_luminance:0,geometry_opacity:1,coat_darkening:1,diffuse_roughness:0,transmission:0,subsurface:0,sheen:0,emission:0,opacity:1,thin_film_thickness:0,coat_affect_color:0,coat_affect_roughness:0};function Ni(e){let t=new TextDecoder().decode(e);if(!t.trimStart().startsWith(`<`))throw new I(`It is no MaterialX document.`);let n=new DOMParser().parseFromString(t,`application/xml`);if(n.querySelector(`parsererror`)!==null||!n.querySelector(`materialx`))throw new I(`It is no MaterialX document.`);let r=[...n.querySelectorAll(`${ki}, standard_surface`)];if(r.length!==1)throw new I(`It has ${r.length} shaders of kind open_pbr_surface or standard_surface, and the page opens one; ${Oi}`);let i=r[0],a=new Map;for(let e of i.querySelectorAll(`input`)){let t=e.getAttribute(`name`)??``;if([`nodename`,`nodegraph`,`interfacename`,`output`].some(t=>e.hasAttribute(t)))throw new I(`Its input ${t} is an image or a graph; ${Oi}`);[`float`,`color3`,`boolean`].includes(e.getAttribute(`type`)??``)&&a.set(t,Ri(e,t))}let o=i.localName!==ki,s=e=>{let[t,n]=o&&ji[e]||[e,Ai[e]];return a.get(t)??n},c=e=>o?1/Math.sqrt(e):Math.sqrt(2/(1+e*e)),l=Object.entries(Mi).flatMap(([e,t])=>z(a.get(e)??t).every(e=>e===t)?[]:[e]);o&&J(s(`coat_weight`))>0&&l.push(`the coat that does not darken`);let u=J(s(`base_metalness`))>=.5,d={of:s,stretch:c,metalWeight:o?1:J(s(`specular_weight`))};return o&&u||!z(s(`specular_color`)).some(e=>e!==1)||l.push(`specular_color`),{...Pi(d,l),lost:l}}function Pi(e,t){let{of:n}=e,r=e=>{let r=J(n(e));return r!==0&&r!==1&&t.push(`${e} between 0 and 1`),r>=.5},i=r(`coat_weight`),a=[];i&&a.push(Ii(e,`coat`,J(n(`coat_ior`)),n(`coat_color`)));let[o,s]=[J(n(`base_weight`)),z(n(`base_color`))],c=yn(s.map(e=>e*o)),l=J(n(`specular_weight`)),u;if(r(`base_metalness`)){let t=B(c,t=>Math.min(t*e.metalWeight,1));u={kind:`conductor`,...Li(e,`specular`),r0:t}}else if(l===0)u={kind:`diffuse`,reflectance:c};else{let t=i?J(n(`coat_ior`)):R.AIR,r=Fi(J(n(`specular_ior`))/t,l),o=Ci(r),s=B(c,e=>e/(1-o+e*o));a.push(Ii(e,`specular`,r*t,1)),u={kind:`diffuse`,reflectance:s}}return{bottom:u,coats:a.map((e,t)=>({...e,id:t+1}))}}function Fi(e,t){let n=(e-1)/(e+1)*Math.sqrt(t),r=Math.min(Math.max(n,-.99),.99);return(1+r)/(1-r)}function Ii(e,t,n,r){let i={color:r,body:0,bodyColor:.8,g:0};return{id:0,on:!0,...Li(e,t),ior:n,...i}}function Li({of:e,stretch:t},n){let r=J(e(`${n}_roughness`)),i=1-J(e(`${n}_roughness_anisotropy`)),a=r**2*t(Math.max(i,.02)),o=e=>Math.min(Math.max(e,R.MIN_ALPHA),1),s=o(a);return i===1?{alpha:s}:{alpha:s,alphaV:o(i*a)}}function Ri(e,t){let n=e.getAttribute(`value`)??``,r=n===`true`?[1]:n===`false`?[0]:n.split(`,`).map(Number);if(![1,3].includes(r.length)||n.trim()===``||!r.every(Number.isFinite))throw new I(`Its input ${t} is neither a number nor a colour.`);if(r.length===1)return r[0];let i=e.closest(`[colorspace]`)?.getAttribute(`colorspace`)??`lin_rec709`,a=r;if(i===`lin_rec709`||i===`lin_rec709_scene`||i===``)return yn(a);if(i!==`srgb_texture`)throw new I(`Its input ${t} is in the colour space ${i}; ${Oi}`);return B(yn(a),e=>e<=.04045?e/12.92:((e+.055)/1.055)**2.4)}function J(e){let[t,n,r]=z(e);return(t+n+r)/3}var zi=class extends Error{constructor(){super(`a later request has taken the place of this one`)}},Bi=class{port;promised=new Map;count=0;loaded={latentSize:0,widths:1,fingerprint:``};layer=this.remote(`layer`);f=this.remote(`f`);albedo=this.remote(`albedo`);table=this.remote(`table`);basisTexels=this.remote(`basisTexels`);occlusion=this.remote(`occlusion`);readExr=this.remote(`readExr`);constructor(e){this.port=e,e.addEventListener(`message`,({data:e})=>this.receive(e))}get latentSize(){return this.loaded.latentSize}get widths(){return this.loaded.widths}get fingerprint(){return this.loaded.fingerprint}async load(e){this.loaded=await this.call(`load`,[e],[e])}encodeMeasured(e){return this.call(`encodeMeasured`,[e],[e])}walk(e,t,n,r,i){if(i?.aborted)return Promise.reject(new zi);let a=this.count;i?.addEventListener(`abort`,()=>this.port.postMessage({cancelled:a},[]));let o=e=>r(e);return this.call(`walk`,[e,...t,n],[],o)}readMesh(e,t,n){return this.call(`readMesh`,[e,t],[e.buffer],e=>n(e))}remote(e){return(...t)=>this.call(e,t)}call(e,t,n=[],r){let i=this.count++;return new Promise((a,o)=>{this.promised.set(i,{resolve:a,reject:o,soFar:r}),this.port.postMessage({id:i,call:e,args:t},n)})}receive(e){let t=this.promised.get(e.id);if(`soFar`in e)t?.soFar?.(e.soFar);else if(this.promised.delete(e.id),`result`in e)t?.resolve(e.result);else if(`superseded`in e)t?.reject(new zi);else{let{name:n,message:r}=e.error;t?.reject(n===`FileError`?new jt(r):Error(r))}}},Vi=`weights.safetensors`,Hi=`anisotropic.safetensors`,Ui=10,Wi=class{isotropic;start;second=null;constructor(e,t=()=>Ki(Hi)){this.isotropic=e,this.start=t}anisotropic(){return this.second??=this.start().catch(e=>{throw this.second=null,e}),this.second}async of(e){if(!Rn(e))return this.isotropic;let{bottom:t,coats:n}=e;if(n.length>0&&[t,...n].some(e=>In(e)>Ui))throw new I(`The two widths of a surface differ by more than a factor of ${Ui}, which the networks cannot layer; give closer widths.`);if(t.kind===`codes`&&t.widths!==2)throw new I(`The loaded material is isotropic; give its coats one width, or coat it in Python.`);return this.anisotropic()}};async function Gi(e,t){let{worker:n,broken:r}=await Dt(),i=new Promise((e,n)=>{t?.addEventListener(`abort`,()=>n(new bt))});try{return await Promise.race([e(new Bi(n)),r,i])}finally{n.terminate()}}async function Ki(e=Vi){let t=Et(e),{worker:n,broken:r}=await Dt(),i=new Bi(n);return await Promise.race([(async()=>{let n=await t;if(n===null)throw new I(`The networks are missing beside the page (${e}).`);await i.load(n.buffer)})(),r]),i}var qi=`#version 300 es
// One triangle over the whole viewport.
out vec2 place;

void main() {
    vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
    place = corner;
    gl_Position = vec4(corner, 0.0, 1.0);
}
`,Ji=class extends Error{};function Yi(e){let t=e.getContext(`webgl2`,{antialias:!1,depth:!1,preserveDrawingBuffer:!0,powerPreference:`high-performance`});if(t===null)throw new Ji(`This browser offers no WebGL 2, which the picture needs; the cards and plots work without.`);if(!t.getExtension(`EXT_color_buffer_float`))throw new Ji(`This graphics driver cannot draw into float textures, which the picture needs; the cards and plots work without.`);return t.getExtension(`OES_texture_float_linear`),t.getExtension(`EXT_float_blend`),t}var Xi=class{gl;program;places=new Map;constructor(e,t,n,r={}){this.gl=e;let i=Object.entries(r).map(([e,t])=>`#define ${e} ${t.toFixed(6)}\n`);this.program=e.createProgram();for(let[r,a]of[[e.VERTEX_SHADER,t],[e.FRAGMENT_SHADER,n.replace(/^(#version .*\n)/,`$1${i.join(``)}`)]]){let t=e.createShader(r);e.shaderSource(t,a),e.compileShader(t),e.attachShader(this.program,t),e.deleteShader(t)}if(e.linkProgram(this.program),!e.getProgramParameter(this.program,e.LINK_STATUS)&&!e.isContextLost())throw new Ji(`The graphics driver refused a shader: ${e.getAttachedShaders(this.program).map(t=>e.getShaderInfoLog(t)).join(` `)}${e.getProgramInfoLog(this.program)}`)}delete(){this.gl.deleteProgram(this.program)}use(){this.gl.useProgram(this.program)}set(e,...t){let{gl:n}=this,r=this.place(e);t.length===1?n.uniform1f(r,t[0]):t.length===2?n.uniform2f(r,t[0],t[1]):t.length===3?n.uniform3f(r,t[0],t[1],t[2]):n.uniform4f(r,t[0],t[1],t[2],t[3])}setInteger(e,t){this.gl.uniform1i(this.place(e),t)}setVectors(e,t){this.gl.uniform3fv(this.place(e),t)}setLights(e){let t=t=>{let n=new Float32Array(12);return e.forEach((e,r)=>{n.set(e[t],3*r)}),n};this.setInteger(`lights`,e.length),this.setVectors(`lightDirections`,t(`direction`)),this.setVectors(`lightPowers`,t(`power`))}setMatrix(e,t){t.length===6?this.gl.uniformMatrix3x2fv(this.place(e),!1,t):t.length===9?this.gl.uniformMatrix3fv(this.place(e),!1,t):this.gl.uniformMatrix4fv(this.place(e),!1,t)}setTexture(e,t,n,r){this.gl.activeTexture(this.gl.TEXTURE0+t),this.gl.bindTexture(n,r),this.setInteger(e,t)}place(e){return this.places.has(e)||this.places.set(e,this.gl.getUniformLocation(this.program,e)),this.places.get(e)}};function Zi(e,t){return e.replace(/^#include (\S+)$/gm,(e,n)=>t[n])}function Y(e,t,n={}){return new Xi(e,qi,t,n)}function Qi(e){e.drawArrays(e.TRIANGLES,0,3)}function $i(e,t,n,r,i){e.texParameteri(t,e.TEXTURE_MIN_FILTER,n),e.texParameteri(t,e.TEXTURE_MAG_FILTER,r),e.texParameteri(t,e.TEXTURE_WRAP_S,i),e.texParameteri(t,e.TEXTURE_WRAP_T,i),e.texParameteri(t,e.TEXTURE_WRAP_R,i)}function ea(e,t,n){let r=new Float32Array(4*t*n);e.readPixels(0,0,t,n,e.RGBA,e.FLOAT,r);let i=new Float32Array(3*t*n);for(let e=0;e<t*n;e++)i.set(r.subarray(4*e,4*e+3),3*e);return i}var ta=`#version 300 es
// A level of the environment from the next finer one: sixteen texels with binomial weights.
precision highp float;
precision highp samplerCube;

uniform samplerCube environment; // its base level is the finer one
uniform mat3 face; // to a direction from place on the face
uniform float side; // texels along a side of the finer level

in vec2 place;
out vec4 colour;

void main() {
    vec4 sum = vec4(0.0);
    for (int i = 0; i < 4; i++) {
        for (int k = 0; k < 4; k++) {
            vec2 at = place + (vec2(float(i), float(k)) - 1.5) * (2.0 / side);
            float weight = (i == 1 || i == 2 ? 3.0 : 1.0) * (k == 1 || k == 2 ? 3.0 : 1.0)
                * pow(1.0 + dot(at, at), -1.5);
            sum += vec4(textureLod(environment, face * vec3(at, 1.0), 0.0).rgb, 1.0) * weight;
        }
    }
    colour = vec4(sum.rgb / sum.a, 1.0);
}
`,na=`#version 300 es
// Irradiance over pi by the normal: the mean of the environment, weighted by the cosine.
precision highp float;
precision highp samplerCube;

uniform samplerCube environment;
uniform mat3 face; // to a direction from place on the face
uniform float level; // of the environment whose texels are summed
uniform float side; // texels along a side of that level

in vec2 place;
out vec4 colour;

void main() {
    vec3 normal = normalize(face * vec3(place, 1.0));
    vec4 sum = vec4(0.0);
    for (float y = 1.0 / side - 1.0; y < 1.0; y += 2.0 / side) {
        for (float x = 1.0 / side - 1.0; x < 1.0; x += 2.0 / side) {
            vec3 texel = vec3(x, y, 1.0);
            float solidAngle = pow(dot(texel, texel), -1.5);
            texel = normalize(texel);
            for (int axis = 0; axis < 6; axis++) {
                vec3 light = axis % 3 == 0 ? texel.zxy : axis % 3 == 1 ? texel.yzx : texel;
                light = axis < 3 ? light : -light;
                float weight = max(dot(normal, light), 0.0) * solidAngle;
                sum += vec4(textureLod(environment, light, level).rgb, 1.0) * weight;
            }
        }
    }
    colour = vec4(sum.rgb / sum.a, 1.0);
}
`,ra=`#version 300 es
// A face of the environment from a panorama, as Mitsuba turns it: the first row is the zenith, the
// first column +y, and a quarter on is +x.
precision highp float;

uniform sampler2D panorama;
uniform mat3 face;

in vec2 place;
out vec4 colour;

void main() {
    vec3 direction = normalize(face * vec3(place, 1.0));
    vec2 at = vec2(atan(direction.x, direction.y) / 6.28318531,
                   acos(clamp(direction.z, -1.0, 1.0)) / 3.14159265);
    colour = vec4(textureLod(panorama, at, 0.0).rgb, 1.0);
}
`,ia=`#version 300 es
// Three environments by formula: a studio, a sky and a room. Radiance without the bright lights.
precision highp float;

uniform mat3 face;
uniform bool isPanorama; // place is that in a panorama as Mitsuba turns it, not that on a face
uniform int which;

in vec2 place;
out vec4 colour;

const float PI = 3.14159265;

// 1 inside a rectangle around \`centre\` as seen from the origin, with soft edges.
float panel(vec3 direction, vec3 centre, vec2 half_, float tilt, float soft) {
    vec3 axis = normalize(centre);
    vec3 right = normalize(cross(vec3(0.0, 0.0, 1.0), axis));
    vec3 up = cross(axis, right);
    float ahead = dot(direction, axis);
    if (ahead <= 0.0) {
        return 0.0;
    }
    vec2 at = vec2(dot(direction, right), dot(direction, up)) * length(centre) / ahead;
    at = mat2(cos(tilt), sin(tilt), -sin(tilt), cos(tilt)) * at;
    vec2 inside = smoothstep(half_ + soft, half_ - soft, abs(at));
    return inside.x * inside.y;
}

// A black studio: a large soft key in front, brighter at its lower edge, a fill beside the camera, one
// above, strips behind at both sides, and a pool of light on the floor. The black beside them shows the
// contours of metals.
vec3 studio(vec3 d) {
    vec3 light = mix(vec3(0.04), vec3(0.02), smoothstep(0.0, 0.7, d.z));
    float key = panel(d, vec3(-0.7, -3.0, 1.2), vec2(1.9, 1.5), 0.0, 0.3);
    light += vec3(12.5, 12.4, 12.2) * key * mix(1.0, 0.65, smoothstep(0.1, 0.8, d.z));
    light += vec3(1.5, 1.52, 1.56) * panel(d, vec3(2.2, -2.6, 0.9), vec2(0.8, 1.3), 0.0, 0.5);
    light += vec3(3.0, 3.0, 3.0) * panel(d, vec3(0.3, 0.8, 3.2), vec2(1.5, 0.7), 0.0, 0.4);
    light += vec3(6.2, 6.4, 6.8) * panel(d, vec3(3.4, 1.6, 1.3), vec2(0.4, 1.8), 0.0, 0.2);
    light += vec3(4.6, 4.5, 4.3) * panel(d, vec3(-3.4, 1.5, 1.1), vec2(0.3, 1.7), 0.0, 0.2);
    vec2 at = d.xy / max(-d.z, 1e-3) + vec2(0.1, 0.8);
    vec3 floor_ = vec3(0.03) + vec3(1.25, 1.24, 1.22) / (1.0 + 0.7 * dot(at, at));
    return mix(light, floor_, smoothstep(0.0, -0.08, d.z));
}

// Smooth noise in [0, 1]: a random number at each corner of a grid (Perlin 1985, by values).
float noise(vec2 at) {
    vec2 cell = floor(at), part = smoothstep(0.0, 1.0, at - cell);
    vec4 corners;
    for (int k = 0; k < 4; k++) {
        vec2 corner = cell + vec2(float(k % 2), float(k / 2));
        corners[k] = fract(52.9829189 * fract(dot(corner, vec2(0.06711056, 0.00583715))));
    }
    vec2 rows = mix(corners.xz, corners.yw, part.x);
    return mix(rows.x, rows.y, part.y);
}

// Octaves of noise.
float cloudy(vec2 at) {
    float sum = 0.0, share = 0.5;
    for (int octave = 0; octave < 6; octave++) {
        sum += share * noise(at);
        at = mat2(1.6, 1.2, -1.2, 1.6) * at + 7.3;
        share *= 0.5;
    }
    return sum;
}

// A summer's sky with clouds over trees and a meadow, seen from a terrace.
vec3 sky(vec3 d) {
    vec3 sun = normalize(vec3(-0.50, -0.62, 0.60));
    float near = max(dot(d, sun), 0.0);
    float height = max(d.z, 0.0);
    vec3 light = mix(vec3(0.98, 1.06, 1.14), vec3(0.13, 0.29, 0.72), pow(height, 0.42));
    light += vec3(1.0, 0.85, 0.62) * (0.30 * pow(near, 8.0) + 1.6 * pow(near, 90.0));
    vec2 over = 1.3 * d.xy / (height + 0.22);
    float thick = cloudy(over);
    float cloud = smoothstep(0.46, 0.66, thick) * smoothstep(0.02, 0.2, d.z);
    float lit = smoothstep(0.10, -0.10, cloudy(over + 0.25 * sun.xy) - thick); // thinner to the sun
    light = mix(light, mix(vec3(0.66, 0.70, 0.78), vec3(2.0, 1.92, 1.8), lit), cloud);
    float way = atan(d.y, d.x);
    vec2 around = vec2(cos(way), sin(way));
    float trees = 0.035 + 0.09 * cloudy(4.0 * around + 3.0) + 0.02 * noise(60.0 * around);
    vec3 leaves = mix(vec3(0.05, 0.075, 0.035), vec3(0.13, 0.16, 0.06), noise(25.0 * vec2(way, 3.0 * d.z)));
    light = mix(light, leaves, smoothstep(0.004, -0.004, d.z - trees));
    vec2 at = 1.7 * d.xy / max(-d.z, 1e-3);
    vec3 ground = mix(vec3(0.13, 0.17, 0.055), vec3(0.22, 0.26, 0.10), noise(0.5 * at));
    vec2 joint = abs(fract(at / 1.4) - 0.5) * 1.4;
    float joints = smoothstep(0.66, 0.69, max(joint.x, joint.y)) * smoothstep(-0.15, -0.5, d.z);
    float stone = 0.85 + 0.3 * noise(floor(at / 1.4) + 0.5) * (0.7 + 0.3 * noise(9.0 * at));
    vec3 terrace = vec3(0.50, 0.47, 0.42) * stone * (1.0 - 0.5 * joints);
    float edge = max(abs(at.x), abs(at.y));
    ground = mix(ground, terrace, smoothstep(5.65, 5.55, edge));
    return mix(ground, light, smoothstep(-0.004, 0.004, d.z));
}

// A room with windows behind and on the left, seen from a table in it.
vec3 room(vec3 d) {
    vec3 low = vec3(-3.2, -2.6, -0.9), high = vec3(2.6, 2.8, 1.9);
    vec3 far = mix(low, high, step(0.0, d)) / (abs(d) + 1e-6) * sign(d);
    float away = min(far.x, min(far.y, far.z));
    vec3 at = d * away;
    vec3 light;
    if (away == far.z && d.z < 0.0) { // wooden floor
        float board = floor(at.y / 0.28);
        float shade = 0.85 + 0.15 * sin(board * 7.3) + 0.05 * sin(at.x * 9.0 + board * 3.0);
        light = vec3(0.40, 0.26, 0.165) * shade * (0.7 + 0.6 * smoothstep(-2.6, 2.6, at.y));
    } else if (away == far.z) { // ceiling
        light = vec3(0.95, 0.92, 0.87) * (0.7 + 0.3 * smoothstep(-2.6, 2.8, at.y));
    } else {
        light = vec3(0.58, 0.53, 0.465) * (0.8 + 0.2 * smoothstep(-2.6, 2.8, at.y));
        light *= 0.7 + 0.3 * smoothstep(-0.9, -0.3, at.z);
        light = mix(light, vec3(0.34, 0.31, 0.28), smoothstep(-0.72, -0.735, at.z)); // skirting
    }
    if (away == far.y && d.y > 0.0) { // windows
        float column = abs(abs(at.x + 0.3) - 1.15);
        float open = smoothstep(0.62, 0.59, column) * smoothstep(0.92, 0.89, abs(at.z - 0.55));
        float frame = smoothstep(0.03, 0.045, column) * smoothstep(0.03, 0.045, abs(at.z - 0.75));
        float trees = 0.35 + 0.9 * cloudy(vec2(1.7 * at.x, 0.0));
        vec3 leaves = mix(vec3(0.35, 0.5, 0.2), vec3(0.85, 1.0, 0.5), noise(vec2(14.0 * at.x, 14.0 * at.z)));
        vec3 outside = mix(leaves, vec3(3.0, 3.4, 3.9), smoothstep(-0.06, 0.06, at.z - trees));
        light = mix(light, outside, open * frame);
        float curtain = smoothstep(0.62, 0.66, column) * smoothstep(0.86, 0.82, column);
        vec3 cloth = vec3(1.05, 1.0, 0.9) * (0.75 + 0.25 * sin(55.0 * at.x));
        light = mix(light, cloth, curtain);
    }
    if (away == far.x && d.x > 0.0) { // a lamp beside
        float lamp = smoothstep(0.34, 0.26, length(vec2(at.y + 1.3, (at.z - 0.35) * 1.1)));
        light = mix(light, vec3(5.5, 4.0, 2.4), lamp);
    }
    if (away == far.x && d.x < 0.0) { // a wide window with four panes
        vec2 pane = abs(vec2(at.y + 0.7, at.z - 0.65));
        float open = smoothstep(1.62, 1.55, pane.x) * smoothstep(1.02, 0.95, pane.y);
        float frame = smoothstep(0.03, 0.06, pane.x) * smoothstep(0.03, 0.06, pane.y);
        light = mix(light, vec3(7.6, 8.0, 8.6), open * frame);
    }
    return light;
}

void main() {
    vec3 direction = normalize(face * vec3(place, 1.0));
    if (isPanorama) {
        float phi = PI * (place.x + 1.0), theta = 0.5 * PI * (place.y + 1.0);
        direction = vec3(sin(theta) * sin(phi), sin(theta) * cos(phi), cos(theta));
    }
    vec3 light = which == 0 ? studio(direction) : which == 1 ? sky(direction) : room(direction);
    colour = vec4(light, 1.0);
}
`,aa=Math.log2(256)+1,oa=16,sa=Math.log2(256/oa),ca=[[0,0,-1,0,-1,0,1,0,0],[0,0,1,0,-1,0,-1,0,0],[1,0,0,0,0,1,0,1,0],[1,0,0,0,0,-1,0,-1,0],[1,0,0,0,-1,0,0,0,1],[-1,0,0,0,-1,0,0,0,-1]],la=[`studio`,`sky`,`room`],ua={direction:en([-.5,-.62,.6]),power:[3.4,3.05,2.55]};function da(e){return e===`sky`?[ua]:[]}function fa(e){return e===`own`?0:la.indexOf(e)}var pa=class{gl;texture;irradiance;convolve;frame;halve;places;panorama;constructor(e,t){this.gl=e;let n=t?e.LINEAR_MIPMAP_NEAREST:e.LINEAR_MIPMAP_LINEAR;this.texture=ma(e,aa,256,n),this.irradiance=ma(e,1,oa,e.LINEAR),this.convolve=Y(e,na),this.frame=e.createFramebuffer(),this.halve=Y(e,ta),this.places=Y(e,ia),this.panorama=Y(e,ra)}drawFormula(e){this.places.use(),this.places.setInteger(`which`,fa(e)),this.places.setInteger(`isPanorama`,0),this.drawFaces(this.places,this.texture,256,0),this.drawLevels()}panoramaOf(e){let{gl:t,places:n}=this,[r,i]=[1024,512],a=t.createTexture();t.bindTexture(t.TEXTURE_2D,a),t.texStorage2D(t.TEXTURE_2D,1,t.RGBA32F,r,i),t.bindFramebuffer(t.FRAMEBUFFER,this.frame);let o=t.TEXTURE_2D;t.framebufferTexture2D(t.FRAMEBUFFER,t.COLOR_ATTACHMENT0,o,a,0),t.viewport(0,0,r,i),t.disable(t.DEPTH_TEST),t.disable(t.SCISSOR_TEST),n.use(),n.setInteger(`which`,fa(e)),n.setInteger(`isPanorama`,1),Qi(t);let s=ea(t,r,i);return t.bindFramebuffer(t.FRAMEBUFFER,null),t.deleteTexture(a),{width:r,height:i,pixels:s}}drawPanorama(e){let{gl:t}=this,n=t.createTexture();t.bindTexture(t.TEXTURE_2D,n);let{width:r,height:i,pixels:a}=e;t.texImage2D(t.TEXTURE_2D,0,t.RGB16F,r,i,0,t.RGB,t.FLOAT,a),$i(t,t.TEXTURE_2D,t.LINEAR,t.LINEAR,t.CLAMP_TO_EDGE),t.texParameteri(t.TEXTURE_2D,t.TEXTURE_WRAP_S,t.REPEAT),this.panorama.use(),this.panorama.setTexture(`panorama`,0,t.TEXTURE_2D,n),this.drawFaces(this.panorama,this.texture,256,0),this.drawLevels(),t.deleteTexture(n)}drawLevels(){let{gl:e,halve:t,convolve:n}=this;t.use(),t.setTexture(`environment`,0,e.TEXTURE_CUBE_MAP,this.texture);for(let n=1;n<aa;n++)e.texParameteri(e.TEXTURE_CUBE_MAP,e.TEXTURE_BASE_LEVEL,n-1),e.texParameteri(e.TEXTURE_CUBE_MAP,e.TEXTURE_MAX_LEVEL,n-1),t.set(`side`,256>>n-1),this.drawFaces(t,this.texture,256>>n,n);e.texParameteri(e.TEXTURE_CUBE_MAP,e.TEXTURE_BASE_LEVEL,0),e.texParameteri(e.TEXTURE_CUBE_MAP,e.TEXTURE_MAX_LEVEL,aa-1),n.use(),n.setTexture(`environment`,0,e.TEXTURE_CUBE_MAP,this.texture),n.set(`level`,sa),n.set(`side`,oa),this.drawFaces(n,this.irradiance,oa,0)}drawFaces(e,t,n,r){let{gl:i}=this;i.disable(i.DEPTH_TEST),i.disable(i.SCISSOR_TEST),i.bindFramebuffer(i.FRAMEBUFFER,this.frame),i.viewport(0,0,n,n),ca.forEach((n,a)=>{let o=i.TEXTURE_CUBE_MAP_POSITIVE_X+a;i.framebufferTexture2D(i.FRAMEBUFFER,i.COLOR_ATTACHMENT0,o,t,r),e.setMatrix(`face`,n),Qi(i)}),i.bindFramebuffer(i.FRAMEBUFFER,null)}};function ma(e,t,n,r){let i=e.createTexture();return e.bindTexture(e.TEXTURE_CUBE_MAP,i),e.texStorage2D(e.TEXTURE_CUBE_MAP,t,e.RGBA16F,n,n),$i(e,e.TEXTURE_CUBE_MAP,r,e.LINEAR,e.CLAMP_TO_EDGE),i}var ha=[[0,.035],[.15,.035],[.27,.032],[.3,.01],[.33,0],[.375,.03],[.425,.12],[.47,.26],[.497,.42],[.503,.56],[.502,.64],[.501,.672],[.498,.684],[.491,.69],[.491,.692],[.498,.698],[.501,.71],[.5,.76],[.492,.85],[.47,.93],[.42,.99],[.33,1.028],[.2,1.05],[.1,1.056],[0,1.058]],ga=[_a([0,0],[.39,0]),[[.39,0],[.405,0],[.41,.01],[.41,.02],..._a([.41,.02],[.41,.1]).slice(1)],_a([.41,.1],[.23,.1]),[[.23,.1],[.15,.12],[.13,.22],[.2,.28]],[[.2,.28],[.4,.3],[.56,.42],[.59,.66],[.6,.74],[.61,.785],[.66,.81],[.672,.816],[.666,.828],[.652,.824],[.585,.8],[.575,.77],[.565,.7],[.545,.58],[.36,.53],[0,.53]]];function _a(e,t){let n=n=>[e[0]+n*(t[0]-e[0]),e[1]+n*(t[1]-e[1])];return[e,n(1/3),n(2/3),t]}var va=[[0,.04],[.18,.04],[.27,.03],[.31,0],[.36,0],[.38,.05],[.42,.2],[.56,.5],[.66,.85],[.67,1.12],[.58,1.4],[.38,1.62],[.24,1.78],[.2,1.95],[.22,2.12],[.3,2.24],[.335,2.285],[.325,2.3],[.29,2.28],[.2,2.16],[.16,1.95],[.16,1.8],[.1,1.7],[0,1.68]],ya=[[0,.05],[.2,.05],[.26,.03],[.28,0],[.33,0],[.35,.05],[.48,.12],[.66,.3],[.76,.52],[.8,.7],[.81,.745],[.795,.76],[.77,.745],[.755,.7],[.71,.53],[.6,.33],[.42,.17],[.24,.11],[0,.1]],ba=[[0,.03],[.3,.03],[.4,.02],[.43,0],[.46,0],[.48,.03],[.62,.07],[.8,.12],[.87,.145],[.885,.16],[.87,.175],[.8,.165],[.66,.13],[.58,.095],[.5,.085],[.3,.08],[0,.08]],xa=[[0,0],[1.425,0],[1.5,.075],[1.5,.15],[1.5,.225],[2,.45],[2,.9],[2,1.35],[1.75,1.875],[1.5,2.4],[1.4375,2.53125],[1.3375,2.53125],[1.4,2.4]],Sa=[[1.3,2.4],[1.3,2.55],[.4,2.55],[.2,2.7],[0,2.85],[.8,3.15],[0,3.15]],Ca=[[[-1.6,0,2.025],[-1.6,-.3,2.025],[-1.5,-.3,2.25],[-1.5,0,2.25]],[[-2.3,0,2.025],[-2.3,-.3,2.025],[-2.5,-.3,2.25],[-2.5,0,2.25]],[[-2.7,0,2.025],[-2.7,-.3,2.025],[-3,-.3,2.25],[-3,0,2.25]],[[-2.7,0,1.8],[-2.7,-.3,1.8],[-3,-.3,1.8],[-3,0,1.8]],[[-2.7,0,1.575],[-2.7,-.3,1.575],[-3,-.3,1.35],[-3,0,1.35]],[[-2.5,0,1.275],[-2.5,-.3,1.275],[-2.65,-.3,1.0875],[-2.65,0,1.0875]],[[-2,0,1.05],[-2,-.3,1.05],[-1.9,-.3,.75],[-1.9,0,.75]]],wa=[[[1.7,0,1.575],[1.7,-.66,1.575],[1.7,-.66,.75],[1.7,0,.75]],[[2.6,0,1.575],[2.6,-.66,1.575],[3.1,-.66,.975],[3.1,0,.975]],[[2.3,0,2.25],[2.3,-.25,2.25],[2.4,-.25,2.175],[2.4,0,2.175]],[[2.7,0,2.55],[2.7,-.25,2.55],[3.3,-.25,2.55],[3.3,0,2.55]],[[2.8,0,2.625],[2.8,-.25,2.625],[3.525,-.25,2.64375],[3.525,0,2.64375]],[[2.9,0,2.625],[2.9,-.15,2.625],[3.45,-.15,2.6625],[3.45,0,2.6625]],[[2.8,0,2.55],[2.8,-.15,2.55],[3.2,-.15,2.55],[3.2,0,2.55]]];function Ta({radius:e}){return 3*e}function Ea(e){switch(e){case`goblet`:return Ha(ga.map(e=>Na(ka(e),128,(e.length-1)*8)),.41);case`ball`:return Ha([Na(Da,96,64)],.5);case`caddy`:return Ha([Na(Oa(ha),96,128)],.42);case`plate`:return Ha([Na(Oa(ba),128,96)],.6);case`bowl`:return Ha([Na(Oa(ya),128,128)],.34);case`sheet`:return Ha([La(96)],.6);case`vase`:return Ha([Na(Oa(va),96,128)],.46);case`teapot`:return Ha([Na(ka(xa),96,72),Na(ka(Sa),72,48),Va(Ma(Ca),32,60),Va(Ma(wa),32,48)],1.9)}}function Da(e){let t=Math.PI*(e-.5);return[Math.cos(t),1+Math.sin(t)]}function Oa(e){let t=e.length-1,n=([e,t])=>[-e,t],r=[n(e[1]),...e,n(e[t-1])];return e=>{let n=e*t,i=Math.min(Math.floor(n),t-1),a=n-i;return ja([(1-a)**3/6,(3*a**3-6*a**2+4)/6,(-3*a**3+3*a**2+3*a+1)/6,a**3/6],r.slice(i,i+4))}}function ka(e){let t=(e.length-1)/3;return n=>{let r=Math.min(Math.floor(n*t),t-1);return ja(Aa(n*t-r),e.slice(3*r,3*r+4))}}function Aa(e){let t=1-e;return[t**3,3*t**2*e,3*t*e**2,e**3]}function ja(e,t){let n=0,r=0;return t.forEach((t,i)=>{n+=e[i]*t[0],r+=e[i]*t[1]}),[n,r]}function Ma(e){let t=(e.length-1)/3;return(n,r)=>{let i=Math.min(Math.floor(r*t),t-1),a=Aa(r*t-i),o=Aa(n<.5?2*n:2-2*n),s=[0,0,0];for(let t=0;t<4;t++)for(let n=0;n<4;n++)for(let r=0;r<3;r++)s[r]+=a[t]*o[n]*e[3*i+t][n][r];return[s[0],n<.5?s[1]:-s[1],s[2]]}}function Na(e,t,n){return Va((t,n)=>{let[r,i]=e(n),a=2*Math.PI*t;return[r*Math.cos(a),r*Math.sin(a),i]},t,n)}var Pa=.09,Fa=8,Ia=6;function La(e){let t={vertices:[],tangents:[],faces:[]};for(let n of[1,-1]){let r=t.vertices.length/8;for(let i=0;i<=e;i++)for(let a=0;a<=e;a++){let[o,s,c]=za(2*a/e-1,2*i/e-1),l=Pa*(1-c**Ia)**(1/Ia)+.03*(1-c*c),u=en(Ba(o,s,l));if(t.vertices.push(o,s,Pa+n*l,u[0],u[1],n*u[2]),t.vertices.push(.5+.5*o,.5+.5*n*s),t.tangents.push(...Ra([u[0],u[1],n*u[2]],n)),i===e||a===e)continue;let d=r+i*(e+1)+a,f=d+e+1;n>0?t.faces.push(d,d+1,f+1,d,f+1,f):t.faces.push(d,f+1,d+1,d,f,f+1)}}return t}function Ra([e,t,n],r){let i=[1-e*e,-e*t,-e*n];return Math.hypot(...i)>1e-6?en(i):[0,0,-r*Math.sign(e)]}function za(e,t){let n=Math.max(Math.abs(e),Math.abs(t));if(n===0)return[0,0,0];let r=(Math.abs(e)**Fa+Math.abs(t)**Fa)**(1/Fa),i=Math.sin(Math.PI/2*n);return[e/r*i,t/r*i,i]}function Ba(e,t,n){let r=(Math.abs(e)**Fa+Math.abs(t)**Fa)**(1/Fa),i=Math.max(n-.03*(1-r*r),0)/Pa,a=r**5+i**5*.06*r/Pa,o=e=>r===0?0:Math.sign(e)*(Math.abs(e)/r)**7;return[a*o(e),a*o(t),i**5/Pa]}function Va(e,t,n){let r=[],i=[],a=[],o=1e-4;for(let s=0;s<=n;s++){let c=s/n,l=Math.min(Math.max(c,2*o),1-2*o);for(let u=0;u<=t;u++){let d=u%t/t,f=Zt(e((d+o)%1,l),e((d+1-o)%1,l)),p=Zt(e(d,l+o),e(d,l-o)),[m,h]=e(d,c),g=Math.min(Math.max((u+(Math.hypot(m,h)>1e-6?0:s===0?.5:-.5))/t,0),1);if(r.push(...e(d,c),...en($t(f,p)),g,c),i.push(...en(f)),s===n||u===t)continue;let _=s*(t+1)+u,v=_+t+1;a.push(_,_+1,v+1,_,v+1,v)}}return{vertices:r,tangents:i,faces:a}}function Ha(e,t){let n=t=>e.reduce((e,n)=>e+n[t].length,0),r=new Float32Array(n(`vertices`)),i=new Float32Array(n(`tangents`)),a=new Uint32Array(n(`faces`)),[o,s]=[0,0];for(let t of e){r.set(t.vertices,8*o),i.set(t.tangents,3*o);for(let e=0;e<t.faces.length;e++)a[s++]=o+t.faces[e];o+=t.vertices.length/8}let c=[1/0,1/0,1/0],l=[-1/0,-1/0,-1/0];for(let e=0;e<r.length;e+=8)for(let t=0;t<3;t++)c[t]=Math.min(c[t],r[e+t]),l[t]=Math.max(l[t],r[e+t]);let u=[0,1,2].map(e=>(c[e]+l[e])/2),[d,f]=[0,0];for(let e=0;e<r.length;e+=8){let[t,n]=[r[e]-u[0],r[e+1]-u[1]];d=Math.max(d,Math.hypot(t,n,r[e+2]-u[2])),f=Math.max(f,Math.hypot(t,n))}return{vertices:r,tangents:i,faces:a,centre:[u[0],u[1],u[2]],radius:d,width:f,halfHeight:(l[2]-c[2])/2,footprint:t}}function Ua(e,t){return e[t+1]===0&&e[t+2]===0&&e[t+3]===0}function Wa(e,t,n){let r=mn(e[t+1],e[t+2],n),i=e[t+3];return i===0?r:r+i*hn(n,e[t+4],e[t+5])}function Ga(e,t,n,r){if(Ua(e,t))return 0;let[i,a,o]=[n.directions,6*r,e[t]];return vn(o,n.widths===1?o:e[t+6],i[a],i[a+1],i[a+2],i[a+3],i[a+4],i[a+5])*Wa(e,t,n.cosD[r])}function Ka(e,t){return Float64Array.from(t.cosD,(n,r)=>Ga(e,0,t,r))}var{HALF_ANGLE_SHARE:qa,MIN_TANGENT:Ja,MAX_TANGENT:Ya,MAX_DIFFERENCE:Xa,MIN_COSINE:Za}=un;function Qa(e){let t=2;for(let n=0;n<64;n++)t=(1+t)**(1/(e+1));return Array.from({length:e},(e,n)=>t**-(n+1))}var $a=.004,eo=.015,to={along:24,across:24,differences:6,turns:4},no={along:48,across:48,differences:10,turns:6};function ro(e){let{along:t,across:n,differences:r,turns:i}=e,a=t*n*r*i,o=new Float32Array(3*a),s=new Float32Array(3*a),c=(e,t)=>$a*(3001**(e/(t-1))-1),l=0;for(let e=0;e<i;e++)for(let a=0;a<r;a++)for(let u=0;u<n;u++)for(let d=0;d<t;d++,l+=3){let[f,p]=[c(d,t),c(u,n)],m=Math.hypot(f,p,1),h=[f/m,p/m,1/m],g=Math.PI/2*(a/(r-1)),_=Math.PI*e/i,v=[Math.sin(g)*Math.cos(_),Math.sin(g)*Math.sin(_)],y=(v[0]*h[0]+v[1]*h[1])/(1+h[2]),b=[v[0]-y*h[0],v[1]-y*h[1],-y*(h[2]+1)];for(let[e,t]of[[o,1],[s,-1]])e.set(io(h,b,Math.cos(g),t),l)}return{wi:o,wo:s}}function io(e,t,n,r){let[i,a,o]=e.map((e,i)=>n*e+r*t[i]),s=Math.max(o,eo),c=Math.hypot(i,a,s);return[i/c,a/c,s/c]}function ao(e){let t=new Float32Array(e.length/3*4);for(let n=0,r=0;n<e.length;n+=3,r+=4)for(let i=0;i<3;i++)t[r+i]=Math.log(Math.max(e[n+i],1e-8));return t}var oo={1:{azimuths:1,cosines:32},2:{azimuths:8,cosines:16}},so=Float32Array.from({length:16},(e,t)=>5.9*t),co=so.map(e=>Math.cos(e*Math.PI/180)),lo=Float32Array.from({length:241},(e,t)=>(t-120)*.745),uo=Float32Array.from({length:33},(e,t)=>(t-16)*5),fo=4096,po=200,mo=class e{cores;page;generation=0;tables=[];bright=null;texture=null;plane=N(null);albedo=N(null);walk=N(null);widths=1;rotation=0;core;material=null;stack=null;albedoIsOld=!0;timer=0;abort=new AbortController;wanted=null;latest=null;busy=!1;key=``;constructor(e,t){this.cores=e,this.page=t,this.core=e.isotropic}show(e){let t=`${e.texture?.texture.id??``}${e.rotation}${vo(e.stack)}`;(t!==this.key||e.table?.logs!==this.latest?.table?.logs)&&(this.key=t,this.wanted=this.latest=e,this.work())}async drawPlane(){let{material:e}=this;if(e===null)return;this.walk.value=null,this.later();let t=go(lo,this.page.incidence(),this.rotation),n=await this.core.f(e,...t);e===this.material&&(this.plane.value=n)}frozen(){let t=Object.create(e.prototype);return Object.assign(t,this,{tables:[...this.tables],busy:!1})}async another(){let{material:e,generation:t}=this;if(e===null||this.busy||this.tables.length>=48)return!1;let n=await this.table(this.core,e,this.tables.length);return t!==this.generation||this.busy?!1:(this.tables.push(n),!0)}async light(e){let{material:t,generation:n}=this,r=e?no:to,i=this.bright!==null&&(!e||this.bright.size===r);if(t===null||this.widths===1||i)return;let a=ro(r),o=await this.core.f(t,a.wi,a.wo);n!==this.generation||this.busy||(this.bright={f:o,size:r})}async work(){if(!this.busy){this.busy=!0;try{for(;this.wanted!==null;){let{stack:e,texture:t,table:n,rotation:r}=this.wanted;this.wanted=null,this.abort.abort(),this.walk.value=null;let i=await this.cores.of(e),a=await i.layer(e),o={...a,table:n??a.table},s=await this.table(i,o,0);this.core=i,this.widths=i.widths,this.rotation=r,this.material=o,this.stack=e,this.texture=t,this.generation++,this.tables=[s],this.bright=null,this.page.changed(),this.albedoIsOld=!0,this.page.plotted()&&await this.drawPlane()}}catch(e){this.key=``,this.page.failed(e,()=>this.show(this.latest))}finally{this.busy=!1}}}later(){clearTimeout(this.timer),this.abort.abort(),this.abort=new AbortController;let{signal:e}=this.abort,t=async()=>{let{material:t}=this;if(!(t===null||e.aborted)){if(this.albedoIsOld){let e=await this.core.albedo(t,co);if(t!==this.material)return;this.albedo.value=e,this.albedoIsOld=!1}await this.compare(e)}};this.timer=setTimeout(()=>t().catch(this.page.failed),po)}async compare(e){let{material:t,stack:n}=this,r=n!==null&&n.bottom.kind!==`codes`&&n.coats.length>0&&this.widths===1;if(t===null||!r||n.energyCompensation||e.aborted)return;let i=go(uo,this.page.incidence(),0),a=await this.core.f(t,...i),o=this.core.latentSize,s=[0,1,2].map(e=>Ka(t.latents.subarray(e*o),Wr.of(...i))),c=t=>{e.aborted||(this.walk.value=_o(t,a,s))};try{let t={seed:1,walks:fo};c(await this.core.walk(n,i,t,c,e))}catch(e){if(!(e instanceof zi))throw e}}table(e,t,n){let r={...oo[e.widths],samples:128};return e.table(t,{...r,shift:ho(n)})}};function ho(e){let[t,n,r]=Qa(3).map(t=>t*128*e%1);return[t,n,r]}function go(e,t,n){let r=t*Math.PI/180,i=n*Math.PI/180,[a,o]=[Math.cos(i),-Math.sin(i)],s=new Float32Array(3*e.length),c=new Float32Array(3*e.length);return e.forEach((e,t)=>{let n=e*Math.PI/180;s.set([-Math.sin(r)*a,-Math.sin(r)*o,Math.cos(r)],3*t),c.set([Math.sin(n)*a,Math.sin(n)*o,Math.cos(n)],3*t)}),[s,c]}function _o({walks:e,f:t,error:n},r,i){let[a,o,s,c]=[0,0,0,0];t.forEach((e,t)=>{let l=Math.floor(t/3),u=Math.cos(uo[l]*Math.PI/180);a+=Math.abs(r[t]-e)*u,o+=n[t]*u,s+=e*u,c+=i[t%3][l]*u});let l=e=>({deviation:a/e,noise:o/e});return{walks:e,f:t,error:n,whole:l(s),rest:l(Math.max(s-c,0))}}function vo(e){return JSON.stringify(e,(e,t)=>t instanceof Float32Array?Array.from(t):t)}var yo=25,bo=100,xo=160,So={card:60,software:3e3},Co=8,wo=15e5,To=3,Eo=16384,Do=4,Oo=[[1,1],[.75,1],[.5,1],[.5,.5],[.25,.5],[.25,.25]],ko=class{slots;failed;gathered=N(0);converged=N(!1);difference=N(null);renderer=null;shot=null;cost=So.card;stripCost=0;slow=!1;changedAt=-1/0;dirty=!0;running=!1;wake=()=>{};count=0;resting=!1;uploaded=[``,``];materialOf=[null,null];brightOf=[null,null];textureOf=[null,null];constructor(e,t){this.slots=e,this.failed=t}setRenderer(e){this.renderer=e,this.uploaded.fill(``),this.materialOf.fill(null),this.brightOf.fill(null),this.textureOf.fill(null),this.slow=e?.isSoftware??!1,this.stripCost=0,this.cost=this.slow?So.software:So.card,this.refresh()}setShot(e){let{shot:t,renderer:n}=this;this.shot=e,t!==null&&this.count>0&&jo(t)===jo(e)&&n!==null?(n.show(e),this.measure(n,e)):this.refresh()}measure(e,t){this.difference.value=t.comparison===`difference`?e.difference(t):null}async whole(){for(;this.count===0&&this.running;)await new Promise(requestAnimationFrame);if(this.renderer===null||this.count===0)throw Ao();return this.renderer}refresh(){this.dirty=!0,this.changedAt=performance.now(),this.count=0,this.resting=!1,this.gathered.value=0,this.converged.value=!1,this.wake(),this.run()}async run(){if(!this.running){this.running=!0;try{for(await null;await this.step();)await new Promise(requestAnimationFrame)}catch(e){this.failed(e)}finally{this.running=!1}}}async step(){let{renderer:e,shot:t}=this;if(e===null||t===null)return!1;let n=Mo(t);if(n.some(e=>this.slots[e].tables.length===0))return!1;if(this.dirty)return this.dirty=!1,e.hasLights&&await Promise.all(n.map(e=>this.slots[e].light(!1))),await this.preview(e,t,n),!0;let r=this.changedAt+xo-performance.now();return r>0?(await new Promise(e=>{this.wake=e,setTimeout(e,r)}),!0):this.rest(e,t,n)}async rest(e,t,n){if(!this.resting){if(e.hasLights&&await Promise.all(n.map(e=>this.slots[e].light(!0))),this.dirty)return!0;this.resting=!0,this.count=0}if(this.count>=this.frames)return this.converged.value=!0,!1;for(let e of n)if(this.slots[e].texture===null&&this.slots[e].tables.length<=this.count&&(!await this.slots[e].another()||!this.resting))return!0;return await this.improve(e,t,n)&&(this.count++,this.gathered.value=this.count/this.frames),!0}get frames(){let{shot:e,renderer:t}=this;if(t===null||e===null)return 48;let n=Mo(e).every(e=>this.slots[e].texture!==null)?To*48:48;if(!this.slow)return n;let r=Math.round(wo/t.pixels(e));return Math.min(Math.max(r,Co),n)}restingScale(e,t){return!this.slow||t.part!==void 0?1:Math.min(Math.sqrt(wo/(this.frames*e.pixels(t))),1)}async preview(e,t,n){let r=e.pixels(t)/1e6,[i,a]=Oo.find(([e,t])=>this.cost*r*e**2*t<yo)??Oo.at(-1);for(let t of n)this.upload(e,t,null);e.beginFrame(t,i),e.drawStrip(t,0,a,0,1),e.endFrame(t,0),this.learn(await e.finished()-this.stripCost,r*i**2*a)}async improve(e,t,n){let r=this.restingScale(e,t),i=e.pixels(t)/1e6*r**2;for(let t of n)this.upload(e,t,this.count);let a=Math.min(Math.ceil(1e6*i/Eo),32),o=Math.min(Math.max(Math.ceil(this.cost*i/bo),1),a);e.beginFrame(t,r);let s=[];for(let n=0;n<o;n++)if(e.drawStrip(t,this.count,1,n/o,(n+1)/o),s.push(await e.finished()),!this.resting)return!1;e.endFrame(t,this.count),this.measure(e,t),o>=Do&&(this.stripCost=Math.min(...s));let c=s.reduce((e,t)=>e+t);return this.learn(c-o*this.stripCost,i),!0}learn(e,t){this.cost+=(Math.max(e,0)/t-this.cost)*.5}upload(e,t,n){let{tables:r,generation:i,material:a,bright:o,texture:s,widths:c}=this.slots[t],l=r[n??0]??r[0],u=`${i}.${n}`;if(l!==void 0&&this.uploaded[t]!==u){let{rotation:r}=this.slots[t],i={...oo[c],samples:128};e.setTable(t,l,i,r,n===null),this.uploaded[t]=u}this.textureOf[t]!==s&&(this.textureOf[t]=s,e.setTexels(t,s)),c===1&&a!==null&&this.materialOf[t]!==a&&(this.materialOf[t]=a,e.setMaterial(t,a)),o!==null&&this.brightOf[t]!==o.f&&(e.setBright(t,o.f,o.size),this.brightOf[t]=o.f)}};function Ao(){return new I(`There is no picture to save.`)}function jo({exposure:e,tone:t,background:n,scale:r,...i}){return JSON.stringify([i,n===`environment`])}function Mo(e){return e.comparison===`off`?[e.slot]:[0,1]}var No=.8,Po=18;function Fo(e,t,n,r=[0,0]){let i=e.radius/(No*Math.tan(t.fov*Math.PI/360)),a=Math.max(t.elevation,Po)*Math.PI/180,o=e.halfHeight*Math.cos(a)+e.width*Math.sin(a),s=Math.max(o,e.width/n)/No,c=s/(i*t.zoom),l=c*n,u=t.azimuth*Math.PI/180,d=t.elevation*Math.PI/180,f=[Math.cos(d)*Math.sin(u),-Math.cos(d)*Math.cos(u),Math.sin(d)],p=[Math.cos(u),Math.sin(u),0],m=[-Math.sin(d)*Math.sin(u),Math.sin(d)*Math.cos(u),Math.cos(d)],[h,g]=t.pan,_=e.centre.map((e,t)=>e+i*f[t]-s*(h*p[t]+g*m[t])),v=i-1.5*e.radius,y=i+1.5*e.radius,b=(e,t)=>[...e.map(e=>e*t),-t*Qt(e,_)],x=[-f[0],-f[1],-f[2]],S=b(x,1),C=b(p,1/l).map((e,t)=>e+r[0]*S[t]),ee=b(m,1/c).map((e,t)=>e+r[1]*S[t]),w=b(x,(y+v)/(y-v));w[3]-=2*y*v/(y-v);let T=[C,ee,w,S];return{eye:_,right:[p[0]*l,p[1]*l,p[2]*l],up:[m[0]*c,m[1]*c,m[2]*c],forward:x,projection:[0,1,2,3].flatMap(e=>T.map(t=>t[e]))}}function Io({eye:e,projection:t,...n}){let r=t.map((e,t)=>Math.floor(t/4)===2?-e:e);return{...n,eye:[e[0],e[1],-e[2]],projection:r}}function Lo(e,{azimuths:t,cosines:n,samples:r},i){let a=t*n,o=new Float32Array(4*a*(2*r+2)),s=o.subarray(8*a*r),c=zo(e,{azimuths:t,cosines:n,samples:r});for(let i=0;i<a;i++){let l=(i%n+.5)/n,u=Math.sqrt(1-l*l),d=.5*Math.PI*Math.floor(i/n)/Math.max(t-1,1),[f,p]=[u*Math.cos(d),u*Math.sin(d)],m=e.subarray(8*i*r,8*(i+1)*r),h=c.subarray(i%n*4,i%n*4+3);for(let e=0;e<m.length;e+=8){let[t,n,c]=[m[e]+f,m[e+1]+p,m[e+2]+l],u=Math.hypot(t,n,c)||1,d=Math.log2(Math.max(m[e+6],1e-6)),g=h.map((t,n)=>m[e+3+n]-t*Ro(m,e));for(let t=0;t<3;t++)s[4*(a+i)+t]+=m[e+3+t]/r;let _=a*e+4*i;o.set([t/u,n/u,c/u,d],_),o.set(g,_+4*a)}s.set(h,4*i)}return i&&s.set(Bo(s.subarray(4*a),n),4*a),o}function Ro(e,t){return e[t+6]>0?e[t+2]/(Math.PI*e[t+6]):0}function zo(e,{cosines:t,samples:n}){let r=new Float32Array(4*t);for(let i=0;i<e.length;i+=8){let a=4*(Math.floor(i/(8*n))%t),o=Ro(e,i);for(let t=0;t<3;t++)r[a+t]+=o*e[i+3+t];r[a+3]+=o*o}let i=Bo(r,t);return i.map((e,t)=>e/Math.max(i[t|3],1e-9))}function Bo(e,t){return e.map((n,r)=>{let i=Math.floor(r/4)%t,a=Math.min(4,i>>1,t-1-i),o=0;for(let t=-a;t<=a;t++)o+=e[r+4*t];return o/(2*a+1)})}function Vo(e){return e.length/128**2}var Ho=`#version 300 es
// The share of its light that each place of the ground has beside the object: the environment in many
// directions, by their cosines, without those in which the object hides it.
precision highp float;
precision highp samplerCube;
precision highp sampler2DArray;

const int MOST_LIGHTS = 4;
const float PI = 3.14159265;

uniform samplerCube environment;
uniform sampler2DArray shadows; // of a direction each, see core/occlusion.ts
uniform int axes;
uniform vec2 turn;
uniform vec3 lightDirections[MOST_LIGHTS];
uniform vec3 lightPowers[MOST_LIGHTS];
uniform int lights;

in vec2 place;
out vec4 colour;

void main() {
    vec3 open = vec3(0.0), all = vec3(1e-6);
    float count = float(axes);
    float level = 8.0 - 0.5 * log2(max(count, 1.0)); // its texels are as large as the share of one direction
    for (int axis = 0; axis < axes; axis++) {
        float z = (float(axis) + 0.5) / count;
        float phi = float(axis) * PI * (3.0 - sqrt(5.0));
        vec3 direction = vec3(sqrt(1.0 - z * z) * vec2(cos(phi), sin(phi)), z);
        direction.xy = vec2(turn.x * direction.x + turn.y * direction.y,
                            turn.x * direction.y - turn.y * direction.x);
        vec3 light = z * textureLod(environment, direction, level).rgb;
        for (int i = 0; i < lights; i++) { // spread over the directions beside it
            float narrow = 0.4 * count;
            float near = exp((dot(direction, lightDirections[i]) - 1.0) * narrow);
            light += lightPowers[i] * lightDirections[i].z * near * narrow * count / (4.0 * PI * PI);
        }
        all += light;
        open += light * (1.0 - texelFetch(shadows, ivec3(gl_FragCoord.xy, axis), 0).r);
    }
    colour = vec4(axes == 0 ? vec3(1.0) : open / all, 1.0);
}
`,Uo=`#version 300 es
// The ground's light with the steps between directions smoothed, the more the farther from the object.
precision highp float;

uniform sampler2D sharp;
uniform float contact; // radius of the object relative to half the square

in vec2 place;
out vec4 colour;

void main() {
    float radius = 0.12 * max(length(place) - 0.5 * contact, 0.01);
    vec4 sum = vec4(0.0);
    for (int k = 0; k < 24; k++) {
        float angle = 2.39996323 * float(k);
        vec2 shift = radius * sqrt((float(k) + 0.5) / 24.0) * vec2(cos(angle), sin(angle));
        sum += textureLod(sharp, 0.5 * (place + shift) + 0.5, 0.0);
    }
    colour = sum / 24.0;
}
`,Wo=class{gl;texture;program;soften;sharp;frame;shadows;axes=0;key=``;constructor(e){this.gl=e,this.program=Y(e,Ho),this.frame=e.createFramebuffer(),this.shadows=e.createTexture(),this.soften=Y(e,Uo);let t=()=>{let t=e.createTexture();return e.bindTexture(e.TEXTURE_2D,t),e.texStorage2D(e.TEXTURE_2D,1,e.RGBA16F,128,128),$i(e,e.TEXTURE_2D,e.LINEAR,e.LINEAR,e.CLAMP_TO_EDGE),t};this.sharp=t(),this.texture=t(),this.setShadows(new Uint8Array)}setShadows(e){let{gl:t}=this;this.axes=Vo(e),this.key=``;let n=t.TEXTURE_2D_ARRAY,[r,i]=this.axes>0?[128,this.axes]:[1,1],a=this.axes>0?e:new Uint8Array(1);t.activeTexture(t.TEXTURE0),t.bindTexture(n,this.shadows),t.pixelStorei(t.UNPACK_ALIGNMENT,1),t.texImage3D(n,0,t.R8,r,r,i,0,t.RED,t.UNSIGNED_BYTE,a),$i(t,n,t.NEAREST,t.NEAREST,t.CLAMP_TO_EDGE)}changed(){this.key=``}light(e,t,n,r){let i=String(n);if(i===this.key)return;this.key=i;let{gl:a,program:o,soften:s}=this;a.viewport(0,0,128,128),a.disable(a.DEPTH_TEST),a.disable(a.SCISSOR_TEST),o.use(),o.setTexture(`environment`,0,a.TEXTURE_CUBE_MAP,e.texture),o.setTexture(`shadows`,1,a.TEXTURE_2D_ARRAY,this.shadows),o.setInteger(`axes`,this.axes),o.set(`turn`,...n),o.setLights(t),this.into(this.sharp),s.use(),s.setTexture(`sharp`,0,a.TEXTURE_2D,this.sharp),s.set(`contact`,r),this.into(this.texture),a.bindFramebuffer(a.FRAMEBUFFER,null)}into(e){let{gl:t}=this;t.bindFramebuffer(t.FRAMEBUFFER,this.frame);let n=t.TEXTURE_2D;t.framebufferTexture2D(t.FRAMEBUFFER,t.COLOR_ATTACHMENT0,n,e,0),Qi(t)}},Go=`// The parts of object.frag for anisotropic materials: tables by the cosine and the azimuth of the view,
// in the frame of the material's tangent.
uniform int azimuths; // the table's columns are the cosines of one azimuth after the other
uniform sampler3D bright; // ln f by half vector and difference
uniform int turns; // azimuths of the difference in \`bright\`, one slab after the other
uniform float rotation; // of the material's tangent [radians]

#include basis.glsl

// The frame along the tangent, mirrored so that the view is in the first quadrant.
Frame tangentFrame(Frame frame, ivec2 pixel) {
    vec4 stored = texelFetch(normals, pixel, 0);
    mat3 axes = basis(normalize(stored.xyz));
    float angle = stored.w + rotation;
    vec3 tangent = turned(cos(angle) * axes[0] + sin(angle) * axes[1]);
    tangent = normalize(tangent - dot(tangent, frame.z) * frame.z);
    vec3 bitangent = cross(frame.z, tangent);
    vec3 view = frame.view.x * frame.x + frame.view.z * frame.z;
    vec2 flat_ = vec2(dot(view, tangent), dot(view, bitangent));
    vec2 side = vec2(flat_.x < 0.0 ? -1.0 : 1.0, flat_.y < 0.0 ? -1.0 : 1.0);
    return Frame(side.x * tangent, side.y * bitangent, frame.z, vec3(abs(flat_), frame.view.z));
}

vec3 reflected(Frame frame) {
    int columns = textureSize(table, 0).x / azimuths;
    float column = clamp(frame.view.z * float(columns) - 0.5, 0.0, float(columns) - 1.0);
    float row = atan(frame.view.y, frame.view.x + 1e-9) / 1.5707963 * float(azimuths - 1);
    int left = int(column), below = min(int(row), azimuths - 2);
    int right = min(left + 1, columns - 1);
    float across = column - float(left), up = clamp(row - float(below), 0.0, 1.0);
    ivec4 places = ivec4(left, right, left, right) + ivec2(below, below + 1).xxyy * columns;
    vec4 shares = vec4((1.0 - across) * (1.0 - up), across * (1.0 - up), (1.0 - across) * up, across * up);
    int last = textureSize(table, 0).y - 2;
    vec3 total = vec3(0.0), albedo = vec3(0.0);
    for (int k = 0; k < 4; k++) {
        total += float(samples) * shares[k] * texelFetch(table, ivec2(places[k], last), 0).rgb;
        albedo += shares[k] * texelFetch(table, ivec2(places[k], last + 1), 0).rgb;
    }
    vec3 even = textureLod(irradiance, bent, 0.0).rgb;
    own = albedo * meanLight(frame.z);
    vec3 sum = total * mix(own, even, openness);
    for (int i = 0; i < samples; i++) {
        vec4 facets[4], between = vec4(0.0);
        vec3 weights[4], weight = vec3(0.0);
        bool isOne = true;
        for (int k = 0; k < 4; k++) {
            facets[k] = texelFetch(table, ivec2(places[k], 2 * i), 0);
            weights[k] = texelFetch(table, ivec2(places[k], 2 * i + 1), 0).rgb;
            isOne = isOne && dot(facets[0].xyz, facets[k].xyz) > 0.97
                && abs(facets[0].w - facets[k].w) < 2.0;
            between += shares[k] * facets[k];
            weight += shares[k] * weights[k];
        }
        total += weight;
        if (isOne) {
            sum += weight * mirrored(frame, between);
        } else { // of different lobes of the proposal
            for (int k = 0; k < 4; k++) {
                sum += shares[k] * weights[k] * mirrored(frame, facets[k]);
            }
        }
    }
    return max(sum, 0.0) * albedo / max(total, 1e-6);
}

// f of the view and a light by the slopes of the half vector and by the difference, see
// anisotropic_table.ts.
vec3 f(Frame frame, vec3 light) {
    vec3 local = vec3(dot(light, frame.x), dot(light, frame.y), dot(light, frame.z));
    vec3 sum = frame.view + local;
    float size = length(sum);
    vec3 half_ = sum / size;
    vec2 side = vec2(half_.x < 0.0 ? -1.0 : 1.0, half_.y < 0.0 ? -1.0 : 1.0);
    half_ = vec3(side * half_.xy, max(half_.z, 1e-3));
    vec3 difference = (frame.view - local) * vec3(side, 1.0);
    vec2 flat_ = difference.xy - difference.z / (1.0 + half_.z) * half_.xy;
    vec2 slopes = log2(1.0 + half_.xy / (half_.z * NEAR)) / log2(1.0 + FAR / NEAR);
    float angle = atan(length(flat_), size) * (2.0 / 3.14159265);
    float turn = fract(atan(flat_.y, flat_.x + 1e-12) / 3.14159265) * float(turns);
    int first = int(turn) % turns;
    vec3 extent = vec3(textureSize(bright, 0));
    float slab = extent.z / float(turns);
    vec2 at = (clamp(slopes, 0.0, 1.0) * (extent.xy - 1.0) + 0.5) / extent.xy;
    float place = clamp(angle, 0.0, 1.0) * (slab - 1.0) + 0.5;
    vec3 one = texture(bright, vec3(at, (float(first) * slab + place) / extent.z)).rgb;
    vec3 other = texture(bright, vec3(at, (float((first + 1) % turns) * slab + place) / extent.z)).rgb;
    return exp(mix(one, other, fract(turn)));
}
`,Ko=`#version 300 es
// What lies behind the object: a ground and a wall in the environment's light, or a panorama out of focus;
// with the object's shadow, and its reflection in the ground.
precision highp float;
precision highp samplerCube;

uniform vec3 eye;
uniform vec3 right; // to the picture's right edge, at the distance of 1
uniform vec3 up;
uniform vec3 forward;
uniform vec2 turn;
uniform samplerCube environment;
uniform samplerCube irradiance; // over pi, by the normal
uniform sampler2D ground; // share of the light that it has
uniform sampler2D mirror; // the object as the ground reflects it, times opacity
uniform vec4 toMirror; // from pixels to its texels: shift and factors; 0: there is none
uniform vec2 size; // radius of the object, and half the side of the square in \`ground\`
uniform bool isPanorama;
uniform bool isPlain; // whether there are shadow and reflection alone

in vec2 place;
out vec4 colour;

const float BLUR = 4.0; // level of a panorama
const float WIDER = 3.0; // its width relative to the picture's, to show the horizon from above
const float REFLECTANCE = 0.12; // of the ground

vec3 inEnvironment(vec3 v) {
    return vec3(turn.x * v.x + turn.y * v.y, turn.x * v.y - turn.y * v.x, v.z);
}

// What the ground reflects, times opacity, with more blur away from the contact.
vec4 reflection(vec3 direction) {
    vec2 texel = 1.0 / vec2(textureSize(mirror, 0));
    vec2 at = (gl_FragCoord.xy * toMirror.zw + toMirror.xy) * texel;
    vec4 sum = 2.0 * textureLod(mirror, at, 0.0);
    for (int k = 0; k < 4; k++) {
        float angle = 1.5707963 * float(k) + 0.6;
        sum += textureLod(mirror, at + 1.3 * texel * vec2(cos(angle), sin(angle)), 0.0);
    }
    float share = 0.1 + 0.9 * pow(1.0 - abs(direction.z), 5.0); // of a polished floor, as of Schlick (1994)
    return share * sum / 6.0;
}

void main() {
    vec3 direction = normalize(forward + place.x * right + place.y * up);
    vec3 back = normalize(vec3(-forward.xy, 0.0));
    vec3 light = 0.4 * REFLECTANCE * textureLod(irradiance, inEnvironment(back), 0.0).rgb;
    vec3 shade = vec3(1.0);
    vec4 seen = vec4(0.0);
    if (direction.z < -1e-3 && eye.z > 0.0) {
        vec2 at = (eye - direction * (eye.z / direction.z)).xy;
        float away = length(at) / size.x;
        // A pool of light that fades into the wall
        vec3 pool = REFLECTANCE * textureLod(irradiance, vec3(0.0, 0.0, 1.0), 0.0).rgb;
        light = mix(light, pool, 1.0 / (1.0 + 0.05 * away * away));
        vec2 inside = abs(at) / size.y;
        float border = smoothstep(1.0, 0.8, max(inside.x, inside.y));
        shade = mix(vec3(1.0), textureLod(ground, 0.5 * at / size.y + 0.5, 0.0).rgb, border);
        if (toMirror.z > 0.0 && away < 4.0) {
            seen = reflection(direction);
        }
    }
    if (isPanorama) {
        vec3 wide = normalize(forward + WIDER * (place.x * right + place.y * up));
        light = textureLod(environment, inEnvironment(wide), BLUR).rgb;
    }
    float dark = dot(shade, vec3(0.2126, 0.7152, 0.0722));
    // What is laid over an encoded colour darkens it by the curve of the screen.
    vec4 behind = isPlain ? vec4(vec3(0.0), 1.0 - pow(dark, 1.0 / 2.2)) : vec4(shade * light, 1.0);
    colour = vec4(seen.rgb, seen.a) + (1.0 - seen.a) * behind;
}
`,qo=`// A frame of which z is a normal (Duff et al. 2017).
mat3 basis(vec3 z) {
    float side = z.z >= 0.0 ? 1.0 : -1.0;
    float a = -1.0 / (side + z.z), b = z.x * z.y * a;
    vec3 x = vec3(1.0 + side * z.x * z.x * a, side * b, -side * z.x);
    return mat3(x, vec3(b, side + z.y * z.y * a, -z.y), z);
}
`,Jo=`#version 300 es
// A frame, to be blended with what has been gathered.
precision highp float;

uniform sampler2D frame;

in vec2 place;
out vec4 colour;

void main() {
    colour = texelFetch(frame, ivec2(gl_FragCoord.xy), 0);
}
`,Yo=`#version 300 es
// Exposure, a tone curve, sRGB, and what lies behind the picture; or the colour difference of two
// pictures that lie beside each other.
precision highp float;

uniform sampler2D picture;
uniform float exposure;
uniform int tone; // 0: neutral, 1: filmic, 2: none
uniform vec4 behind; // colour (sRGB) and opacity where the picture is transparent
uniform float scale; // colour difference that is shown by the last colour; 0: one picture, -1: numbers

in vec2 place;
out vec4 colour;

const float START = 0.8 - 0.04;
const float DESATURATION = 0.15;

// "PBR Neutral" of the Khronos Group (2024).
vec3 neutral(vec3 light) {
    float least = min(light.r, min(light.g, light.b));
    float offset = least < 0.08 ? least - 6.25 * least * least : 0.04;
    light -= offset;
    float peak = max(light.r, max(light.g, light.b));
    if (peak < START) {
        return light;
    }
    float rest = 1.0 - START;
    float lowered = 1.0 - rest * rest / (peak + rest - START);
    light *= lowered / peak;
    float grey = 1.0 - 1.0 / (DESATURATION * (peak - lowered) + 1.0);
    return mix(light, vec3(lowered), grey);
}

// The Academy's ACES, as fitted by Hill (2017, BakingLab), with the exposure of three.js.
vec3 filmic(vec3 light) {
    mat3 toAces = mat3(0.59719, 0.07600, 0.02840, 0.35458, 0.90834, 0.13383, 0.04823, 0.01566, 0.83777);
    mat3 toRgb = mat3(1.60475, -0.10208, -0.00327, -0.53108, 1.10813, -0.07276, -0.07367, -0.00605,
                      1.07602);
    vec3 x = toAces * light / 0.6;
    return toRgb * ((x * (x + 0.0245786) - 0.000090537) / (x * (0.983729 * x + 0.4329510) + 0.238081));
}

// Noise of half a step, against bands in smooth gradients.
float dither(vec2 pixel) {
    return fract(52.9829189 * fract(dot(pixel, vec2(0.06711056, 0.00583715)))) - 0.5;
}

// Linear sRGB as it is shown, and opacity, at a place in [0, 1]^2 of the texture.
vec4 shownAt(vec2 at) {
    vec4 texel = max(textureLod(picture, at, 0.0), 0.0);
    float opacity = min(texel.a, 1.0);
    vec3 light = texel.rgb / max(opacity, 1e-4) * exposure;
    if (tone < 2) {
        light = tone == 0 ? neutral(light) : filmic(light);
    }
    return vec4(clamp(light, 0.0, 1.0), opacity);
}

// CIELAB of linear sRGB, with the white of D65 (CIE 15).
vec3 lab(vec3 rgb) {
    mat3 toXyz = mat3(0.4339, 0.2126, 0.0178, 0.3762, 0.7152, 0.1095, 0.1899, 0.0722, 0.8727);
    vec3 xyz = toXyz * rgb; // relative to white
    vec3 t = mix(7.787 * xyz + 16.0 / 116.0, pow(xyz, vec3(1.0 / 3.0)), step(0.008856, xyz));
    return vec3(116.0 * t.y - 16.0, 500.0 * (t.x - t.y), 200.0 * (t.y - t.z));
}

// Colours of a difference from 0 to 1; the legend on the page has the same.
vec3 difference(float x) {
    vec3 colours[5] = vec3[5](vec3(0.0, 0.0, 4.0), vec3(81.0, 18.0, 124.0), vec3(183.0, 55.0, 121.0),
                              vec3(252.0, 137.0, 97.0), vec3(252.0, 253.0, 191.0));
    float at = 4.0 * clamp(x, 0.0, 1.0);
    int low = min(int(at), 3);
    return mix(colours[low], colours[low + 1], at - float(low)) / 255.0;
}

void main() {
    if (scale != 0.0) {
        float border = 0.5 / float(textureSize(picture, 0).x);
        vec2 left = vec2(clamp(0.25 * place.x + 0.25, border, 0.5 - border), 0.5 * place.y + 0.5);
        vec3 between = lab(shownAt(left).rgb) - lab(shownAt(left + vec2(0.5, 0.0)).rgb);
        float size = length(between);
        colour = vec4(scale > 0.0 ? difference(size / scale) : vec3(size), 1.0);
        return;
    }
    vec4 shown = shownAt(0.5 * place + 0.5);
    vec3 encoded = mix(12.92 * shown.rgb, 1.055 * pow(shown.rgb, vec3(1.0 / 2.4)) - 0.055,
                       step(0.0031308, shown.rgb));
    encoded += dither(gl_FragCoord.xy) / 255.0;
    float rest = (1.0 - shown.a) * behind.a;
    colour = vec4(shown.a * encoded + rest * behind.rgb, shown.a + rest); // premultiplied
}
`,Xo=`// What a pixel shows of the object, and the light there.
const int MOST_LIGHTS = 4;

uniform vec3 eye;
uniform vec2 turn; // cosine and sine of the environment's rotation about z
uniform int samples;
uniform float density; // directions taken so far, for the level of detail
uniform samplerCube environment;
uniform float side; // texels along a side of the environment
uniform vec3 lightDirections[MOST_LIGHTS];
uniform vec3 lightPowers[MOST_LIGHTS]; // irradiance at normal incidence
uniform int lights;

uniform float fade; // height at which the image in the ground fades; 0: it is none
uniform samplerCube irradiance; // over pi, by the normal
uniform sampler2D positions; // of the surface that each pixel shows, see surface.frag
uniform sampler2D normals;
uniform sampler2D openings;

// A pixel's frame, in which z is the normal, and its direction to the eye.
struct Frame {
    vec3 x;
    vec3 y;
    vec3 z;
    vec3 view;
};

vec3 turned(vec3 v) {
    return vec3(turn.x * v.x + turn.y * v.y, turn.x * v.y - turn.y * v.x, v.z);
}

vec3 bent; // the mean direction of the light that the object does not hide
float edge; // cosine of the angle about it beyond which light is hidden
float openness; // share of the light that the object does not hide, by the cosine
vec3 own; // light of the object itself where it hides the environment

// The frame where a pixel shows a position.
Frame frameAt(ivec2 pixel, vec3 position) {
    vec3 normal = turned(normalize(texelFetch(normals, pixel, 0).xyz));
    vec3 view = turned(normalize(eye - position));
    float cosine = dot(normal, view);
    if (cosine < 0.004) { // smooth normals may turn away at the silhouette
        normal = normalize(normal + (0.004 - cosine) * view);
        cosine = max(dot(normal, view), 0.004);
    }
    vec3 across = view - cosine * normal;
    float size = length(across);
    vec3 tangent = size > 1e-4
        ? across / size
        : normalize(cross(normal, abs(normal.z) < 0.9 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0)));
    vec4 opening = texelFetch(openings, pixel, 0);
    bent = turned(opening.xyz);
    openness = opening.w;
    // The cosine at the edge of a cone of the openness (Oat and Sander 2007)
    edge = sqrt(max(1.0 - openness / clamp(dot(normal, bent), 0.02, 1.0), 0.0));
    return Frame(tangent, cross(normal, tangent), normal, vec3(size, 0.0, cosine));
}

// The level whose texels are as large as the share of one direction.
float level(vec3 direction, float logPdf) {
    vec3 size = abs(direction);
    float major = max(size.x, max(size.y, size.z));
    float solidAngle = 4.0 * major * major * major / (side * side); // of a texel
    return 0.5 * (-logPdf - log2(density * solidAngle)) + 0.5;
}

// Light on the parts that hide the environment: of all directions, as far as it gets there.
vec3 meanLight(vec3 normal) {
    vec3 both = textureLod(irradiance, normal, 0.0).rgb + textureLod(irradiance, -normal, 0.0).rgb;
    return 0.5 * openness * both;
}

// The share of a direction that is open: of a cone about the bent normal.
float open(vec3 light) {
    float soft = min(edge, 0.25) + 1e-4;
    return openness == 1.0 ? 1.0 : smoothstep(edge - soft, edge + soft, dot(light, bent));
}

// Light from a direction in a frame, drawn by a density.
vec3 incoming(Frame frame, vec3 local, float logPdf) {
    vec3 light = local.x * frame.x + local.y * frame.y + local.z * frame.z;
    return mix(own, textureLod(environment, light, level(light, logPdf)).rgb, open(light));
}

// Light of a surface at a height, times its opacity.
vec4 faded(vec3 light, float height) {
    float opacity = fade > 0.0 ? exp(-height / fade) : 1.0;
    return vec4(light * opacity, opacity);
}
`,Zo=`// Written by \`python viewer/formulas.py\` from the formulas of Python. Do not edit it.

// f [1/sr] of a material by its lobe and the table of its rest.
vec3 material_f(vec3 numbers[6], highp sampler3D table, vec3 wi, vec3 wo) {
    // The lobe: D G / (4 cos_i cos_o) of GGX with the separable Smith term, where
    // wi + wo stands for the half vector.
    float above_i = max(wi.z, 0.0);
    float above_o = max(wo.z, 0.0);
    float half_x = wi.x + wo.x;
    float half_y = wi.y + wo.y;
    float half_z = above_i + above_o;
    float half_xy2 = half_x * half_x + half_y * half_y;
    float half_z2 = half_z * half_z;
    vec3 alpha2 = numbers[0] * numbers[0];
    vec3 remaining = 1.0 - alpha2;
    vec3 ratio = (half_xy2 + half_z2) / (half_xy2 + alpha2 * half_z2 + 1.0e-18);
    vec3 masking_i = above_i + sqrt(alpha2 + remaining * (above_i * above_i));
    vec3 masking_o = above_o + sqrt(alpha2 + remaining * (above_o * above_o));
    vec3 lobe_shape = alpha2 / 3.1415927 * (ratio * ratio) / (masking_i * masking_o);
    float cos_facet = min(0.5 * sqrt(half_x * half_x + half_y * half_y + half_z * half_z), 1.0);
    // Its Fresnel term at the cosine to the facet.
    float away_facet = 1.0 - cos_facet;
    float away2_facet = away_facet * away_facet;
    float fifth_facet = away2_facet * away2_facet * away_facet;
    float cos2_facet = cos_facet * cos_facet;
    float sin2_facet = 1.0 - cos2_facet;
    vec3 difference_facet = (numbers[4] - 1.0) * (numbers[4] + 1.0) - numbers[5] * numbers[5] +
        cos2_facet;
    vec3 size_facet = sqrt(difference_facet * difference_facet + 4.0 * (numbers[4] * numbers[4]) *
        (numbers[5] * numbers[5]));
    vec3 root_facet = sqrt(0.5 * max(size_facet + difference_facet, vec3(0.0, 0.0, 0.0)));
    vec3 imaginary2_facet = 0.5 * max(size_facet - difference_facet, vec3(0.0, 0.0, 0.0));
    vec3 less_facet = root_facet - cos_facet;
    vec3 more_facet = root_facet + cos_facet;
    vec3 across_facet = (less_facet * less_facet + imaginary2_facet) / (more_facet * more_facet +
        imaginary2_facet);
    vec3 product_facet = root_facet * cos_facet;
    vec3 far_facet = imaginary2_facet * cos2_facet + 1.0e-12;
    vec3 third_facet = product_facet - sin2_facet;
    vec3 fourth_facet = product_facet + sin2_facet;
    vec3 parallel_facet = (third_facet * third_facet + far_facet) / (fourth_facet * fourth_facet +
        far_facet);
    vec3 fresnel_facet = numbers[1] * (1.0 - fifth_facet) + numbers[2] * fifth_facet + numbers[3] *
        (0.5 * across_facet * (1.0 + parallel_facet));
    vec3 lobe = lobe_shape * fresnel_facet;
    // The table's coordinates, from the first node to the last.
    vec3 both = wi + wo;
    vec3 apart = wi - wo;
    float z2 = max(both.z * both.z, 1.0e-18);
    float squared = both.x * both.x + both.y * both.y + z2;
    float cos_d = min(0.5 * sqrt(squared), 1.0);
    float across = both.x * both.x + both.y * both.y;
    float node0 = clamp((log(across / z2 + 1.0e-5) - (-11.512925)) * 0.05428681, 0.0, 1.0) * 95.0;
    float node1 = clamp(sqrt(1.0 - cos_d), 0.0, 1.0) * 31.0;
    float node2 = clamp(1.0 - sqrt(1.0 - min(0.5 * abs(apart.z) / max(min(0.5 * both.z, sqrt(across
        / squared * ((1.0 - cos_d) * (1.0 + cos_d)))), 1.0e-9), 1.0)), 0.0, 1.0) * 7.0;
    float place0 = (node0 + 0.5) * 0.010416667;
    float place1 = (node1 + 0.5) * 0.03125;
    float first = node2 + 0.5;
    vec3 texel0_0_place = vec3(first * 0.125, place1, place0);
    vec4 texel0_0 = textureLod(table, texel0_0_place, 0.0);
    vec3 rest = exp(texel0_0.rgb);
    return lobe + rest;
}
`,Qo=`#version 300 es
// Reflected light: a sum over the table's directions, which looks up the prefiltered environment,
// and the bright lights, which are evaluated directly.
precision highp float;
precision highp samplerCube;
precision highp sampler3D;

#include frame.glsl

uniform sampler2D table; // columns: cosines; rows as in direction_table.ts

out vec4 colour;

// Light from the direction that is the mirror image of the view in a facet of the table.
vec3 mirrored(Frame frame, vec4 facet) {
    vec3 half_ = normalize(facet.xyz);
    return incoming(frame, 2.0 * dot(frame.view, half_) * half_ - frame.view, facet.w);
}

#ifdef ANISOTROPIC
#include anisotropic.glsl
#else
#include material.glsl

uniform vec3 lobe[6]; // numbers of the material's lobe
uniform sampler3D rest; // ln f without it, by the coordinates of tables

// The mean light of the diffuse part and of the table's directions by their weights, times the albedo:
// a few directions thus reflect as much as all.
vec3 reflected(Frame frame) {
    int columns = textureSize(table, 0).x;
    float column = clamp(frame.view.z * float(columns) - 0.5, 0.0, float(columns) - 1.0);
    int left = int(column);
    int right = min(left + 1, columns - 1);
    float share = column - float(left);
    int last = textureSize(table, 0).y - 2;
    vec3 total = float(samples) * mix(texelFetch(table, ivec2(left, last), 0).rgb,
                                      texelFetch(table, ivec2(right, last), 0).rgb, share);
    vec3 albedo = mix(texelFetch(table, ivec2(left, last + 1), 0).rgb,
                      texelFetch(table, ivec2(right, last + 1), 0).rgb, share);
    vec3 even = textureLod(irradiance, bent, 0.0).rgb;
    own = albedo * meanLight(frame.z);
    vec3 sum = total * mix(own, even, openness);
    for (int i = 0; i < samples; i++) {
        vec4 first = texelFetch(table, ivec2(left, 2 * i), 0);
        vec4 second = texelFetch(table, ivec2(right, 2 * i), 0);
        vec3 firstWeight = texelFetch(table, ivec2(left, 2 * i + 1), 0).rgb;
        vec3 secondWeight = texelFetch(table, ivec2(right, 2 * i + 1), 0).rgb;
        total += mix(firstWeight, secondWeight, share);
        if (dot(first.xyz, second.xyz) > 0.97 && abs(first.w - second.w) < 2.0) {
            vec4 between = mix(first, second, share);
            sum += mix(firstWeight, secondWeight, share) * mirrored(frame, between);
        } else { // of different lobes of the proposal
            sum += (1.0 - share) * firstWeight * mirrored(frame, first);
            sum += share * secondWeight * mirrored(frame, second);
        }
    }
    return max(sum, 0.0) * albedo / max(total, 1e-6);
}

vec3 f(Frame frame, vec3 light) {
    vec3 local = vec3(dot(light, frame.x), dot(light, frame.y), dot(light, frame.z));
    return material_f(lobe, rest, frame.view, local);
}
#endif

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 position = texelFetch(positions, pixel, 0);
    if (position.w <= 0.0) {
        colour = vec4(0.0);
        return;
    }
    Frame frame = frameAt(pixel, position.xyz);
#ifdef ANISOTROPIC
    frame = tangentFrame(frame, pixel);
#endif
    vec3 sum = reflected(frame);

    for (int i = 0; i < lights; i++) {
        float cosLight = dot(frame.z, lightDirections[i]);
        if (cosLight > 0.0) {
            sum += f(frame, lightDirections[i]) * cosLight * open(lightDirections[i]) * lightPowers[i];
        }
    }
    colour = faded(sum, position.z);
}
`,$o=`#version 300 es
// The object as the camera sees it.
uniform mat4 projection; // world to clip space
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 coordinates;
layout(location = 3) in vec3 tangent;
layout(location = 4) in vec4 bent; // bent normal, 0 before it is known, and openness
out vec3 worldPosition;
out vec3 worldNormal;
out vec3 worldTangent;
out vec2 uv;
out vec4 opening;

void main() {
    worldPosition = position;
    worldNormal = normal;
    worldTangent = tangent;
    uv = coordinates;
    opening = vec4(bent.xyz == vec3(0.0) ? normal : bent.xyz, max(bent.w, 0.02));
    gl_Position = projection * vec4(position, 1.0);
}
`,es=`#version 300 es
// The object's triangles in the colours that were computed for coarse pixels: the mean of the nearest
// ones that show the same part of the surface (Kopf et al. 2007).
precision highp float;

uniform sampler2D shaded;
uniform sampler2D positions; // and 1; -1 for a back, 0 where there is no surface
uniform sampler2D normals;
uniform vec4 toShaded; // from pixels to coarse ones: shift and factors
uniform float near; // distance from the tangent plane at which a surface is another

in vec3 worldPosition;
in vec3 worldNormal;
out vec4 colour;

void main() {
    colour = vec4(0.0, 0.0, 0.0, 1.0);
    if (!gl_FrontFacing) {
        return; // materials do not reflect on their backs
    }
    vec3 normal = normalize(worldNormal);
    vec2 at = gl_FragCoord.xy * toShaded.zw + toShaded.xy - 0.5;
    ivec2 first = ivec2(floor(at)), last = textureSize(shaded, 0) - 1;
    vec2 share = at - vec2(first);
    vec4 sum = vec4(0.0);
    vec4 any = vec4(0.0);
    for (int reach = 0; reach < 2 && sum.a < 1e-3; reach++) {
        for (int y = -reach; y <= 1 + reach; y++) {
            for (int x = -reach; x <= 1 + reach; x++) {
                ivec2 texel = clamp(first + ivec2(x, y), ivec2(0), last);
                vec4 other = texelFetch(positions, texel, 0);
                if (other.w <= 0.0) {
                    continue;
                }
                vec2 apart = abs(share - vec2(x, y));
                float weight = max(1.0 - apart.x, 2e-3) * max(1.0 - apart.y, 2e-3);
                vec3 light = texelFetch(shaded, texel, 0).rgb;
                float aside = dot(other.xyz - worldPosition, normal) / near;
                float facing = max(dot(normal, normalize(texelFetch(normals, texel, 0).xyz)), 0.0);
                any += vec4(light, 1.0) * weight;
                sum += vec4(light, 1.0) * weight * pow(facing, 24.0) * exp(-aside * aside);
            }
        }
    }
    if (sum.a >= 1e-3) {
        colour.rgb = sum.rgb / sum.a;
    } else if (any.a > 0.0) {
        colour.rgb = any.rgb / any.a;
    }
}
`,ts=`#version 300 es
// The surface that a pixel shows, to be shaded once: triangles smaller than pixels would be shaded
// several times each.
precision highp float;

uniform mat3x2 toTexture; // from uv, where a texture of codes is shown
uniform vec2 texels; // along the texture's sides
uniform float coarsest; // the texture's last level

in vec3 worldPosition;
in vec3 worldNormal;
in vec3 worldTangent;
in vec2 uv;
in vec4 opening;
layout(location = 0) out vec4 position; // and 1; -1 for a back, 0 where there is no surface
layout(location = 1) out vec4 normal; // and the tangent's angle in its \`basis\`
layout(location = 2) out vec4 at; // in the texture, and the level whose texels are as large as pixels
layout(location = 3) out vec4 open; // bent normal and openness

#include basis.glsl

void main() {
    position = vec4(worldPosition, gl_FrontFacing ? 1.0 : -1.0);
    open = vec4(normalize(opening.xyz), opening.w);
    mat3 frame = basis(normalize(worldNormal));
    normal = vec4(worldNormal, atan(dot(worldTangent, frame[1]), dot(worldTangent, frame[0])));
    vec2 place = toTexture * vec3(uv, 1.0);
    vec2 x = dFdx(place) * texels, y = dFdy(place) * texels;
    float squared = max(max(dot(x, x), dot(y, y)), 1.0);
    at = vec4(place, min(0.5 * log2(squared), coarsest), 0.0);
}
`,ns=class{gl;width=0;height=0;scale=0;positions;normals;openings;places;shaded;mirror;frame;picture;surface;shading;mirroring;many;single;mean;samples;format;buffers=[];coarse=null;constructor(e){this.gl=e;let t=()=>e.createFramebuffer();this.surface=t(),this.shading=t(),this.mirroring=t(),this.many=t(),this.single=t(),this.mean=t();let n=e.getInternalformatParameter(e.RENDERBUFFER,e.RGBA16F,e.SAMPLES),r=Math.max(0,...n??[]);this.samples=Math.min(4,r);let i=e.getExtension(`EXT_float_blend`)&&e.getExtension(`OES_texture_float_linear`);this.format=i?e.RGBA32F:e.RGBA16F}resize(e,t,n){let{gl:r}=this,i=e===this.width&&t===this.height;if(!(i&&n===this.scale)){if(this.scale=n,!i){[this.width,this.height]=[e,t];for(let e of this.buffers)r.deleteRenderbuffer(e);for(let e of[this.frame,this.picture])r.deleteTexture(e??null);let n=this.buffer(r.RGBA16F,this.samples,e,t),i=this.buffer(r.DEPTH_COMPONENT24,this.samples,e,t);this.buffers=[n,i],r.bindFramebuffer(r.FRAMEBUFFER,this.many);let a=r.FRAMEBUFFER;r.framebufferRenderbuffer(a,r.COLOR_ATTACHMENT0,r.RENDERBUFFER,n),r.framebufferRenderbuffer(a,r.DEPTH_ATTACHMENT,r.RENDERBUFFER,i),this.frame=this.texture(r.RGBA16F,this.single,e,t),this.picture=this.texture(this.format,this.mean,e,t,r.LINEAR)}this.resizeShading(Math.ceil(e*n),Math.ceil(t*n))}}resizeShading(e,t){let{gl:n}=this,{positions:r,normals:i,openings:a,places:o,shaded:s,mirror:c}=this;for(let e of[r,i,a,o,s,c])n.deleteTexture(e??null);n.deleteRenderbuffer(this.coarse),this.coarse=this.buffer(n.DEPTH_COMPONENT24,0,e,t),this.mirror=this.texture(n.RGBA16F,this.mirroring,e,t,n.LINEAR),this.shaded=this.texture(n.RGBA16F,this.shading,e,t);let l=(r,i)=>this.texture(r,this.surface,e,t,n.NEAREST,n.COLOR_ATTACHMENT0+i);this.positions=l(n.RGBA32F,0),this.normals=l(n.RGBA32F,1),this.places=l(n.RGBA32F,2),this.openings=l(n.RGBA16F,3);let u=n.FRAMEBUFFER;n.framebufferRenderbuffer(u,n.DEPTH_ATTACHMENT,n.RENDERBUFFER,this.coarse),n.drawBuffers([0,1,2,3].map(e=>n.COLOR_ATTACHMENT0+e)),n.bindFramebuffer(u,null)}bindSurface(){this.emptied(this.surface)}bindShaded(e){this.emptied(e?this.mirroring:this.shading)}bind(){this.emptied(this.many)}emptied(e){let{gl:t}=this;t.bindFramebuffer(t.FRAMEBUFFER,e),t.clearColor(0,0,0,0),t.clear(t.COLOR_BUFFER_BIT|t.DEPTH_BUFFER_BIT)}resolve(){let{gl:e,width:t,height:n}=this;e.bindFramebuffer(e.READ_FRAMEBUFFER,this.many),e.bindFramebuffer(e.DRAW_FRAMEBUFFER,this.single),e.blitFramebuffer(0,0,t,n,0,0,t,n,e.COLOR_BUFFER_BIT,e.NEAREST)}bindFrame(){this.gl.bindFramebuffer(this.gl.FRAMEBUFFER,this.single)}bindMean(){let{gl:e}=this;e.bindFramebuffer(e.FRAMEBUFFER,this.mean),e.viewport(0,0,this.width,this.height)}read(){let{gl:e,width:t,height:n}=this;e.bindFramebuffer(e.FRAMEBUFFER,this.mean);let r=ea(e,t,n);e.bindFramebuffer(e.FRAMEBUFFER,null);let i=new Float32Array(r.length);for(let e=0;e<n;e++)i.set(r.subarray(3*t*e,3*t*(e+1)),3*t*(n-1-e));return{width:t,height:n,pixels:i}}buffer(e,t,n,r){let{gl:i}=this,a=i.createRenderbuffer();return i.bindRenderbuffer(i.RENDERBUFFER,a),i.renderbufferStorageMultisample(i.RENDERBUFFER,t,e,n,r),a}texture(e,t,n,r,i=this.gl.NEAREST,a=this.gl.COLOR_ATTACHMENT0){let{gl:o}=this,s=o.createTexture();return o.bindTexture(o.TEXTURE_2D,s),o.texStorage2D(o.TEXTURE_2D,1,e,n,r),$i(o,o.TEXTURE_2D,i,i,o.CLAMP_TO_EDGE),o.bindFramebuffer(o.FRAMEBUFFER,t),o.framebufferTexture2D(o.FRAMEBUFFER,a,o.TEXTURE_2D,s,0),s}},rs=`#version 300 es
// Reflected light of a texture of codes: a texel's material by the exported shader code, directions
// by its proposal with the prefiltered environment, and the bright lights directly.
precision highp float;
precision highp samplerCube;
precision highp sampler2DArray;

#include frame.glsl

float stored[4 * LAYERS]; // bytes of the texel, in [0, 1]

#include material.glsl

uniform sampler2DArray codes; // of the texture
uniform highp sampler3D functions; // of the basis
uniform sampler2D places; // in the texture, see surface.frag
uniform vec3 start; // of the sequence of directions

// Steps of the sequence (Roberts 2018).
const vec3 STEPS = vec3(0.8191725133961645, 0.6710436067037893, 0.5497004779019703);

out vec4 colour;

uvec3 mixed(uvec3 v) {
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    return v;
}

// Three numbers in [0, 1) for each pixel: pcg3d of Jarzynski and Olano 2020.
vec3 hash(uvec3 v) {
    v = mixed(v * 1664525u + 1013904223u);
    v = mixed(v ^ (v >> 16u));
    return vec3(v >> 8u) / 16777216.0;
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 position = texelFetch(positions, pixel, 0);
    if (position.w <= 0.0) {
        colour = vec4(0.0);
        return;
    }
    // One texel is drawn in proportion to its weight, so that the mean of the frames filters f and
    // not the code.
    vec3 at = texelFetch(places, pixel, 0).xyz;
    vec3 random = fract(hash(uvec3(pixel, 0)) + start.zxy);
    float level = floor(at.z + random.z);
    at.xy += SPREAD * (random.xy - 0.5) / vec2(textureSize(codes, int(level)).xy);
    for (int layer = 0; layer < LAYERS; layer++) {
        vec4 four = textureLod(codes, vec3(at.xy, float(layer)), level);
        stored[4 * layer] = four.r;
        stored[4 * layer + 1] = four.g;
        stored[4 * layer + 2] = four.b;
        stored[4 * layer + 3] = four.a;
    }
    UrushiMaterial material = urushi_material();
    Frame frame = frameAt(pixel, position.xyz);
    UrushiProposal proposal = urushi_proposal(material, frame.view);

    own = 0.5 * meanLight(frame.z); // of an object of average albedo
    vec3 sum = vec3(0.0);
    for (int i = 0; i < samples; i++) {
        vec3 direction = urushi_draw(proposal, frame.view, fract(start + float(i) * STEPS));
        float pdf = urushi_density(proposal, frame.view, direction);
        if (pdf > 0.0) {
            vec3 weight = urushi_f(material, frame.view, direction, functions) * (direction.z / pdf);
            sum += weight * incoming(frame, direction, log2(pdf));
        }
    }
    sum /= float(samples);

    for (int i = 0; i < lights; i++) {
        vec3 light = lightDirections[i];
        vec3 local = vec3(dot(light, frame.x), dot(light, frame.y), dot(light, frame.z));
        if (local.z > 0.0) {
            sum += urushi_f(material, frame.view, local, functions) * local.z * open(light) * lightPowers[i];
        }
    }
    colour = faded(sum, position.z);
}
`;function is(e,t){let{texture:n,shader:r,basis:i}=t,a=Math.max(Math.ceil(n.usedBytes/4),1),o=Y(e,Zi(rs,{"frame.glsl":Xo,"material.glsl":r}).replaceAll(`LAYERS`,String(a)),{SPREAD:+!n.nearest}),s=ss(e,n,a),[c,l,u,d,f,p]=n.toTexture;return{program:o,texture:s,basis:as(e,e.createTexture(),i),toTexture:[c,d,l,f,u,p],size:n.levels[0],coarsest:n.levels.length-1}}function as(e,t,n){let[r,i]=fn.SHAPE;return os(e,t,[n.length/(4*r*i),i,r],n),t}function os(e,t,[n,r,i],a){e.activeTexture(e.TEXTURE0);let o=e.TEXTURE_3D;e.bindTexture(o,t);let s=e.getExtension(`OES_texture_float_linear`)===null?e.RGBA16F:e.RGBA32F;e.texImage3D(o,0,s,n,r,i,0,e.RGBA,e.FLOAT,a),$i(e,o,e.LINEAR,e.LINEAR,e.CLAMP_TO_EDGE)}function ss(e,t,n){let{levels:r,texels:i,texelBytes:a}=t,o=e.getParameter(e.MAX_TEXTURE_SIZE),[s,c]=r[0];if(Math.max(s,c)>o)throw new I(`The texture has ${s} by ${c} texels; the graphics driver takes ${o} a side.`);let l=e.TEXTURE_2D_ARRAY,u=e.createTexture();e.activeTexture(e.TEXTURE0),e.bindTexture(l,u),e.texStorage3D(l,r.length,e.RGBA8,s,c,n),e.pixelStorei(e.UNPACK_ALIGNMENT,4);let d=0;return r.forEach(([t,r],o)=>{let s=new Uint8Array(4*t*r);for(let c=0;c<n;c++){for(let e=0;e<t*r;e++){let t=(d+e)*a+4*c;for(let n=0;n<4;n++)s[4*e+n]=i[t+n]}e.texSubImage3D(l,o,0,0,c,t,r,1,e.RGBA,e.UNSIGNED_BYTE,s)}d+=t*r}),$i(e,l,e.NEAREST_MIPMAP_NEAREST,e.NEAREST,cs(e,t.wrap)),u}function cs(e,t){return t===`clamp`?e.CLAMP_TO_EDGE:t===`mirror`?e.MIRRORED_REPEAT:e.REPEAT}var ls={count:1,column:0,row:0},us=Zi(Qo,{"frame.glsl":Xo,"material.glsl":Zo,"anisotropic.glsl":Zi(Go,{"basis.glsl":qo})}),[ds,fs,ps]=[.5,.5,4],ms=32,hs=class{canvas;gl;object;anisotropic=null;surface;paint;backdrop;blend;display;map;targets;ground;array;slots=[null,null];buffers;mesh;lights=[];isPanorama=!1;constructor(e){this.canvas=e;let t=Yi(e);this.gl=t,this.object=Y(t,us);let n=Zi(ts,{"basis.glsl":qo});this.surface=new Xi(t,$o,n),this.paint=new Xi(t,$o,es),this.backdrop=Y(t,Ko),this.blend=Y(t,Jo),this.display=Y(t,Yo),this.map=new pa(t,this.isSoftware),this.targets=new ns(t),this.ground=new Wo(t),this.array=t.createVertexArray();let r=()=>t.createBuffer();this.buffers=[r(),r(),r(),r()],this.mesh=Ea(`ball`),this.uploadMesh()}setMesh(e){e!==this.mesh&&(this.mesh=e,this.ground.setShadows(new Uint8Array),this.uploadMesh())}setOcclusion({openings:e,shadows:t}){let{gl:n}=this;this.ground.setShadows(t),n.bindVertexArray(this.array),n.bindBuffer(n.ARRAY_BUFFER,this.buffers[3]),n.bufferData(n.ARRAY_BUFFER,e,n.STATIC_DRAW),n.enableVertexAttribArray(4),n.vertexAttribPointer(4,4,n.FLOAT,!1,0,0),n.bindVertexArray(null)}setEnvironment(e,t){this.isPanorama=e===`own`&&t!==null,t!==null&&this.isPanorama?(this.map.drawPanorama(t.panorama),this.lights=t.lights):(this.map.drawFormula(e),this.lights=da(e)),this.ground.changed()}get picture(){return this.canvas}get size(){return{width:this.canvas.width,height:this.canvas.height}}get hasLights(){return this.lights.length>0}setTable(e,t,n,r=0,i=!1){let{gl:a}=this,{azimuths:o,cosines:s,samples:c}=n,l=this.slotTextures(e),u=Lo(t,n,i);l.samples=c,l.azimuths=o,l.rotation=r*Math.PI/180,a.activeTexture(a.TEXTURE0),a.bindTexture(a.TEXTURE_2D,l.table);let d=o*s,f=a.TEXTURE_2D,p=2*c+2;a.texImage2D(f,0,a.RGBA32F,d,p,0,a.RGBA,a.FLOAT,u),$i(a,f,a.NEAREST,a.NEAREST,a.CLAMP_TO_EDGE)}setMaterial(e,{latents:t,table:n}){let r=this.slotTextures(e),i=Ot(t,t.length/3);r.lobe=Float32Array.from({length:18},(e,t)=>{let[r,a]=[Math.floor(t/3),t%3];return r>=1&&r<=3&&!n.besideLobe?0:i[a][r]});let a=new Float32Array(n.logs.length/3*4);n.logs.forEach((e,t)=>{a[4*Math.floor(t/3)+t%3]=e}),as(this.gl,r.rest,a)}setBright(e,t,n){let r=this.slotTextures(e);r.turns=n.turns;let i=n.differences*n.turns;os(this.gl,r.bright,[n.along,n.across,i],ao(t))}setTexels(e,t){let n=this.slotTextures(e);n.texels!==null&&(this.gl.deleteTexture(n.texels.texture),this.gl.deleteTexture(n.texels.basis),n.texels.program.delete()),n.texels=t&&is(this.gl,t)}get isSoftware(){let{gl:e}=this,t=e.getExtension(`WEBGL_debug_renderer_info`),n=t?String(e.getParameter(t.UNMASKED_RENDERER_WEBGL)):``;return/swiftshader|llvmpipe|software|basic render/i.test(n)}pixels({comparison:e}){return this.canvas.width*this.canvas.height*(e===`difference`?2:1)}beginFrame(e,t){let{width:n,height:r}=this.canvas;this.targets.resize(e.comparison===`difference`?2*n:n,r,t);let i=this.mesh.width/Ta(this.mesh);this.ground.light(this.map,this.lights,gs(e),i)}drawStrip(e,t,n,r,i){let{gl:a,targets:o}=this,{width:s,height:c,scale:l}=o,[u,d]=[Math.round(r*c),Math.round(i*c)],{count:f,column:p,row:m}=e.part??ls,h=e.comparison===`difference`?s/2:s;a.enable(a.SCISSOR_TEST);for(let r of ys(e,f*h,h)){let i=this.slots[r.slot],s=e=>Math.min(Math.max(e-p*h,0),h),[g,_]=[s(r.from),s(r.to)];if(!i||g===_)continue;let v=[r.offset+r.x-p*h,-m*c,r.width,f*c],y=[r.offset+g,u,_-g,d-u],b=t===0?[0,0]:[bs(t,2)-.5,bs(t,3)-.5],x=([,,t,n])=>Fo(this.mesh,e.view,r.width/(f*c),[2*b[0]/t,2*b[1]/n]),S=(r,s)=>{let c=v.map(e=>Math.round(e*r)),l=x(c),u=s?Io(l):l,d=s?ps:2;a.viewport(...c),a.scissor(..._s(y,r,d)),a.frontFace(s?a.CW:a.CCW),o.bindSurface(),this.placeTexels(i.texels,t),this.drawMesh(this.surface,u),o.bindShaded(s);let f=s?.7*this.mesh.halfHeight:0;this.shade(u,e,i,t,s?fs*n:n,f),a.frontFace(a.CCW);let p=[c[2]/v[2],c[3]/v[3]];return[0,1].map(e=>c[e]+b[e]-(v[e]+b[e])*p[e]).concat(p)},C=x(v),ee=C.eye[2]>0?S(ds*l,!0):null,w=S(l,!1);a.viewport(...v),a.scissor(...y),o.bind(),this.drawBackdrop(C,e,ee),this.drawPaint(C,w)}a.disable(a.SCISSOR_TEST)}endFrame(e,t){let{gl:n,targets:r}=this;r.resolve(),r.bindMean(),this.blend.use(),this.blend.setTexture(`frame`,0,n.TEXTURE_2D,r.frame),n.blendColor(0,0,0,2/(t+2)),t>0&&n.enable(n.BLEND),n.blendFunc(n.CONSTANT_ALPHA,n.ONE_MINUS_CONSTANT_ALPHA),Qi(n),n.disable(n.BLEND),this.show(e)}draw(e){this.beginFrame(e,1),this.drawStrip(e,0,1,0,1),this.endFrame(e,0)}show(e){let{gl:t}=this;t.bindFramebuffer(t.FRAMEBUFFER,null),t.viewport(0,0,this.canvas.width,this.canvas.height),this.drawDisplay(e,e.comparison===`difference`?e.scale:0)}drawDisplay({exposure:e,tone:t,background:n},r){let{gl:i,display:a}=this,o=[1,3,5].map(e=>Number.parseInt(n.slice(e,e+2),16)),s=n.startsWith(`#`)?o.map(e=>e/255):[0,0,0];a.use(),a.setTexture(`picture`,0,i.TEXTURE_2D,this.targets.picture),a.set(`exposure`,2**e),a.setInteger(`tone`,sr.indexOf(t)),a.set(`behind`,...s,Number(n.startsWith(`#`))),a.set(`scale`,r),Qi(i)}difference(e){let{gl:t,targets:n}=this,[r,i]=[n.width>>1,n.height];n.bindFrame(),t.viewport(0,0,r,i),this.drawDisplay(e,-1);let[a,o,s]=[0,0,0],c=ea(t,r,i);for(let e=0;e<c.length;e+=3)c[e]>0&&(a+=c[e],o++,s=Math.max(s,c[e]));return{mean:a/Math.max(o,1),largest:s}}radiance(){return this.targets.read()}panoramaOf(e){return this.map.panoramaOf(e)}async finished(){let{gl:e}=this,t=performance.now(),n=e.fenceSync(e.SYNC_GPU_COMMANDS_COMPLETE,0);if(e.flush(),n===null)return 0;for(;!e.isContextLost();){let t=e.clientWaitSync(n,0,0);if(t===e.ALREADY_SIGNALED||t===e.CONDITION_SATISFIED||t===e.WAIT_FAILED)break;await new Promise(e=>setTimeout(e,2))}return e.deleteSync(n),performance.now()-t}dispose(){this.gl.getExtension(`WEBGL_lose_context`)?.loseContext()}placeTexels(e,t){let n=1/Math.sqrt(t+1),[r,i]=e?.size??[1,1];this.surface.use(),this.surface.setMatrix(`toTexture`,e?.toTexture??[0,0,0,0,0,0]),this.surface.set(`texels`,n*r,n*i),this.surface.set(`coarsest`,e?.coarsest??0)}drawBackdrop(e,t,n){let{gl:r,backdrop:i,mesh:a}=this;r.disable(r.DEPTH_TEST),i.use(),i.set(`eye`,...e.eye),i.set(`right`,...e.right),i.set(`up`,...e.up),i.set(`forward`,...e.forward),i.set(`turn`,...gs(t)),i.setInteger(`isPlain`,Number(t.background!==`environment`)),i.setInteger(`isPanorama`,Number(this.isPanorama)),i.set(`size`,a.width,Ta(a)),i.set(`toMirror`,...n??[0,0,0,0]),i.setTexture(`environment`,0,r.TEXTURE_CUBE_MAP,this.map.texture),i.setTexture(`irradiance`,1,r.TEXTURE_CUBE_MAP,this.map.irradiance),i.setTexture(`ground`,2,r.TEXTURE_2D,this.ground.texture),i.setTexture(`mirror`,3,r.TEXTURE_2D,this.targets.mirror),Qi(r)}drawPaint(e,t){let{gl:n,paint:r,targets:i}=this;r.use(),r.setTexture(`shaded`,0,n.TEXTURE_2D,i.shaded),r.setTexture(`positions`,1,n.TEXTURE_2D,i.positions),r.setTexture(`normals`,2,n.TEXTURE_2D,i.normals),r.set(`toShaded`,...t),r.set(`near`,.02*this.mesh.radius),this.drawMesh(r,e)}drawMesh(e,t){let{gl:n}=this;e.use(),e.setMatrix(`projection`,t.projection),n.bindVertexArray(this.array),n.enable(n.DEPTH_TEST),n.drawElements(n.TRIANGLES,this.mesh.faces.length,n.UNSIGNED_INT,0),n.disable(n.DEPTH_TEST),n.bindVertexArray(null)}shade(e,t,n,r,i,a){let{gl:o,targets:s}=this,{texels:c}=n,l=c?.program??this.programOf(n);l.use();let u=c?Math.max(4,Math.round(ms*i)):Math.max(16,Math.round(n.samples*i));l.set(`eye`,...e.eye),l.set(`turn`,...gs(t)),l.set(`side`,256),l.setInteger(`samples`,u),l.set(`density`,u*(r+1)),l.set(`fade`,a),l.setLights(this.lights),l.setTexture(`environment`,1,o.TEXTURE_CUBE_MAP,this.map.texture),l.setTexture(`irradiance`,5,o.TEXTURE_CUBE_MAP,this.map.irradiance),c?(l.set(`start`,...vs(r*ms)),l.setTexture(`codes`,0,o.TEXTURE_2D_ARRAY,c.texture),l.setTexture(`functions`,7,o.TEXTURE_3D,c.basis),l.setTexture(`places`,2,o.TEXTURE_2D,s.places)):(l.setTexture(`table`,0,o.TEXTURE_2D,n.table),n.azimuths===1?(l.setTexture(`rest`,2,o.TEXTURE_3D,n.rest),l.setVectors(`lobe`,n.lobe)):(l.setTexture(`bright`,2,o.TEXTURE_3D,n.bright),l.setInteger(`azimuths`,n.azimuths),l.setInteger(`turns`,n.turns),l.set(`rotation`,n.rotation))),l.setTexture(`positions`,3,o.TEXTURE_2D,s.positions),l.setTexture(`normals`,4,o.TEXTURE_2D,s.normals),l.setTexture(`openings`,6,o.TEXTURE_2D,s.openings),Qi(o)}programOf({azimuths:e}){return e===1?this.object:(this.anisotropic??=Y(this.gl,us,{NEAR:$a,FAR:12,ANISOTROPIC:1}),this.anisotropic)}slotTextures(e){let{gl:t}=this;return this.slots[e]??={table:t.createTexture(),samples:0,azimuths:1,rotation:0,lobe:new Float32Array(18).fill(0).fill(1,0,3),rest:this.dark(),bright:this.dark(),turns:1,texels:null},this.slots[e]}dark(){let{gl:e}=this,t=e.createTexture();e.bindTexture(e.TEXTURE_3D,t);let n=new Float32Array([-18,-18,-18,0]);return e.texImage3D(e.TEXTURE_3D,0,e.RGBA16F,1,1,1,0,e.RGBA,e.FLOAT,n),$i(e,e.TEXTURE_3D,e.LINEAR,e.LINEAR,e.CLAMP_TO_EDGE),t}uploadMesh(){let{gl:e}=this;e.bindVertexArray(this.array),e.bindBuffer(e.ARRAY_BUFFER,this.buffers[0]),e.bufferData(e.ARRAY_BUFFER,this.mesh.vertices,e.STATIC_DRAW),e.bindBuffer(e.ELEMENT_ARRAY_BUFFER,this.buffers[1]),e.bufferData(e.ELEMENT_ARRAY_BUFFER,this.mesh.faces,e.STATIC_DRAW),[3,3,2].forEach((t,n)=>{e.enableVertexAttribArray(n),e.vertexAttribPointer(n,t,e.FLOAT,!1,32,12*n)}),e.bindBuffer(e.ARRAY_BUFFER,this.buffers[2]),e.bufferData(e.ARRAY_BUFFER,this.mesh.tangents,e.STATIC_DRAW),e.enableVertexAttribArray(3),e.vertexAttribPointer(3,3,e.FLOAT,!1,0,0),e.disableVertexAttribArray(4),e.vertexAttrib4f(4,0,0,0,1),e.bindVertexArray(null)}};function gs(e){let t=e.rotation*Math.PI/180;return[Math.cos(t),Math.sin(t)]}function _s([e,t,n,r],i,a){let[o,s]=[Math.floor(e*i)-a,Math.floor(t*i)-a];return[o,s,Math.ceil((e+n)*i)+a-o,Math.ceil((t+r)*i)+a-s]}function vs(e){let[t,n,r]=Qa(3).map(t=>(.5+t*e)%1);return[t,n,r]}function ys(e,t,n){let r=Math.floor(t/2),i=Math.round(t*e.edge);switch(e.comparison){case`off`:return[{slot:e.slot,x:0,width:t,from:0,to:t,offset:0}];case`side`:return[{slot:0,x:0,width:r,from:0,to:r,offset:0},{slot:1,x:r,width:t-r,from:r,to:t,offset:0}];case`difference`:return[{slot:0,x:0,width:t,from:0,to:t,offset:0},{slot:1,x:0,width:t,from:0,to:t,offset:n}];case`swipe`:return[{slot:0,x:0,width:t,from:0,to:i,offset:0},{slot:1,x:0,width:t,from:i,to:t,offset:0}]}}function bs(e,t){let n=0,r=1;for(let i=e;i>0;i=Math.floor(i/t))r/=t,n+=i%t*r;return n}var xs=[[`B`,2],[`G`,1],[`R`,0]],Ss=20000630,Cs=2,ws=2;function Ts({width:e,height:t,pixels:n}){let r=Es(e,t),i=8*t,a=8+xs.length*4*e,o=r.length+i,s=new Uint8Array(o+t*a);s.set(r);let c=new DataView(s.buffer);for(let i=0;i<t;i++){let t=o+i*a;c.setBigUint64(r.length+8*i,BigInt(t),!0),c.setInt32(t,i,!0),c.setInt32(t+4,a-8,!0),t+=8;for(let[,r]of xs)for(let a=0;a<e;a++,t+=4)c.setFloat32(t,n[3*(i*e+a)+r],!0)}return s}function Es(e,t){let n=xs.flatMap(([e])=>[...Ds(e),...Os(ws,0,1,1)]),r=Os(0,0,e-1,t-1),i=[[`channels`,`chlist`,[...n,0]],[`compression`,`compression`,[0]],[`dataWindow`,`box2i`,r],[`displayWindow`,`box2i`,r],[`lineOrder`,`lineOrder`,[0]],[`pixelAspectRatio`,`float`,ks(1)],[`screenWindowCenter`,`v2f`,ks(0,0)],[`screenWindowWidth`,`float`,ks(1)]];return Uint8Array.from([...Os(Ss,Cs),...i.flatMap(([e,t,n])=>[...Ds(e),...Ds(t),...Os(n.length),...n]),0])}function Ds(e){return[...new TextEncoder().encode(e),0]}function Os(...e){return[...new Uint8Array(Int32Array.from(e).buffer)]}function ks(...e){return[...new Uint8Array(Float32Array.from(e).buffer)]}var As=3840;function js(e,t,n,r,i){let{count:a,width:o,height:s}=Ms(e,t);return Ar(`Drawing the large picture`,async(e,t)=>{let c=Object.assign(document.createElement(`canvas`),{width:o,height:s}),l=document.createElement(`canvas`);[l.width,l.height]=[a*o,a*s];let u=new hs(c);try{i(u);for(let i=0;i<a**2;i++){let[d,f]=[i%a,Math.floor(i/a)],p=e=>t((i+e)/a**2);await Ns(u,n,{...r,part:{count:a,column:d,row:f}},p,e),l.getContext(`2d`).drawImage(c,d*o,(a-1-f)*s)}return await Ps(l)}finally{u.dispose()}})}function Ms(e,{width:t,height:n}){if(e===`2x`)return{count:2,width:t,height:n};let r=Math.max(t,n),i=1;for(;As%i!==0||As/i>r;)i++;let a=e=>Math.max(Math.round(As/i/r*e),1);return{count:i,width:a(t),height:a(n)}}function Ns(e,t,n,r,i){return new Promise((a,o)=>{let s=new ko(t,o);s.setRenderer(e),s.setShot(n),i.addEventListener(`abort`,()=>{s.setRenderer(null),o(new bt)}),F(()=>{r(s.gathered.value),s.converged.value&&a()})})}async function Ps(e){return await new Promise(t=>e.toBlob(t))}var Fs=N(new Map),Is=N(new Map),Ls=N(!1),Rs=new WeakMap;function zs(e){let t=Rs.get(e);return t===void 0&&(t=Gi(t=>t.occlusion(e.vertices,8,e.faces,Ta(e))),Rs.set(e,t)),t}var Bs=new Map;function Vs({object:e,mesh:t}){let n=e===`own`?Is.value.get(t):void 0;if(n!==void 0)return n;let r=e===`own`?`goblet`:e,i=Bs.get(r)??Ea(r);return Bs.set(r,i),i}function Hs({environment:e,panorama:t}){return e===`own`?Fs.value.get(t)??null:null}var Us=N(``),Ws=N(!0),Gs=class{cores;slots;painter;mesh;shot=P(()=>{let{view:e,rotation:t,exposure:n,tone:r,background:i,comparison:a,edge:o,scale:s}=U.value;return{view:e,rotation:t,exposure:n,tone:r,background:i,comparison:a,edge:o,scale:s,slot:U.value.active}});renderer=null;canvas=null;constructor(e){this.cores=e;let t=t=>new mo(e,{changed:()=>this.painter.refresh(),failed:q,incidence:()=>U.peek().incidence,plotted:()=>U.peek().plots&&U.peek().active===t});this.slots=[t(0),t(1)],this.painter=new ko(this.slots,q);let n=P(()=>`${U.value.object} ${U.value.mesh}`);this.mesh=P(()=>(n.value,Vs(U.peek()))),this.bind()}attach(e){this.canvas=e;let t=e=>{e.preventDefault(),this.renderer=null,this.painter.setRenderer(null),Us.value=`The graphics driver has taken the picture away; it returns as soon as the driver allows.`};e.addEventListener(`webglcontextlost`,t),e.addEventListener(`webglcontextrestored`,this.start);let n=new ResizeObserver(()=>this.fit());return n.observe(e),this.fit(),this.start(),()=>{n.disconnect(),e.removeEventListener(`webglcontextlost`,t),e.removeEventListener(`webglcontextrestored`,this.start)}}start=()=>{if(this.canvas!==null){try{this.renderer=new hs(this.canvas),Us.value=``}catch(e){if(!(e instanceof Ji))throw e;Us.value=e.message;return}this.show(this.mesh.peek()),this.renderer.setEnvironment(U.peek().environment,Hs(U.peek())),this.painter.setRenderer(this.renderer)}};show(e){this.renderer?.setMesh(e),this.painter.refresh(),Ls.value=!0;let t=()=>e===this.mesh.peek();zs(e).then(e=>{t()&&(this.renderer?.setOcclusion(e),this.painter.refresh())}).catch(q).finally(()=>{t()&&(Ls.value=!1)})}async radiance(){return(await this.whole()).radiance()}async whole(){return K({turntable:!1}),await zs(this.mesh.peek()),this.painter.whole()}async picture(){return await this.whole(),Ps(this.canvas)}async largePicture(e){let t=await this.whole(),n=this.mesh.peek(),r=await zs(n),{environment:i}=U.peek(),a=Hs(U.peek()),o=[this.slots[0].frozen(),this.slots[1].frozen()];return js(e,t.size,o,this.shot.peek(),e=>{e.setMesh(n),e.setOcclusion(r),e.setEnvironment(i,a)})}async scene(){if(this.renderer===null)throw Ao();let{renderer:e}=this,{view:t,rotation:n,environment:r}=U.peek(),i={mesh:this.mesh.peek(),view:t,rotation:n,...e.size},a=Hs(U.peek());if(a!==null){let e=new Uint8Array(await a.file.arrayBuffer()),t=/\.exr$/i.test(a.file.name)?`exr`:`hdr`;return{...i,environment:{suffix:t,bytes:e},lights:[]}}let o=Ts(e.panoramaOf(r));return{...i,environment:{suffix:`exr`,bytes:o},lights:da(r)}}fit(){if(this.canvas===null)return;let e=Math.min(window.devicePixelRatio||1,2),t=Math.max(1,Math.round(this.canvas.clientWidth*e)),n=Math.max(1,Math.round(this.canvas.clientHeight*e));(t!==this.canvas.width||n!==this.canvas.height)&&(this.canvas.width=t,this.canvas.height=n,this.painter.refresh())}bind(){let{slots:e,painter:t}=this,n=P(()=>U.value.materials),r=P(()=>U.value.comparison!==`off`),i=P(()=>U.value.active);F(()=>{for(let t of[0,1])if(r.value||t===i.value){let r=$s(n.value[t]);r!==null&&e[t].show(r)}});let a=``;F(()=>{let e=JSON.stringify(this.shot.value);e!==a&&t.setShot(this.shot.value),a=e}),F(()=>{let e=this.mesh.value;this.show(e);let{object:t,mesh:n}=U.peek();t===`own`&&!Is.peek().has(n)&&q(new I(tc(`mesh “${n}”`)))});let o=P(()=>U.value.environment),s=P(()=>Hs(U.value));F(()=>{let[e,n]=[o.value,s.value];this.renderer?.setEnvironment(e,n),t.refresh(),e===`own`&&n===null&&q(new I(tc(`panorama “${U.peek().panorama}”`)))});let c=P(()=>U.value.incidence),l=P(()=>U.value.plots);F(()=>{c.value,l.value&&e[i.value].drawPlane().catch(q)}),F(()=>{t.converged.value&&Nr(`The picture has converged.`)})}},X=N(null);async function Ks(e){Ws.value=!0;try{let[t,n]=await Promise.all([Ki(),qs()]);`texture`in n&&await ni(await Js(String(n.texture)),t),`table`in n&&ii(oi(await Js(String(n.table)))),`materials`in n&&!e&&Ur(()=>pr(n,Hr),!1),X.value=new Gs(new Wi(t))}catch(t){q(t,()=>void Ks(e))}finally{Ws.value=!1}}async function qs(){let e=await Et(`start.json`);return e===null?{}:JSON.parse(new TextDecoder().decode(e))}async function Js(e){let t=await Et(e);if(t===null)throw new I(`The file ${e} is missing beside the page.`);return t}var Ys=N([]),Xs=null;function Zs(){return Xs??=Qs().catch(e=>{Xs=null,q(e,()=>void Zs())}),Xs}async function Qs(){let{stored:e={}}=await qs();for(let[t,n]of Object.entries(e).slice(Ys.value.length)){let{bottom:e}=ui(await Js(n),X.value.cores.isotropic);Ys.value=[...Ys.value,{name:t,bottom:e,coats:[],solo:null}]}}function $s(e){let{bottom:t,rotation:n=0}=e;if(t.kind!==`texels`){let t=jn(e);return{stack:t,rotation:n,texture:null,table:ec(e,t)}}let r=ti.value.get(t.texture);return r===void 0?(q(new I(tc(`texture of “${e.name}”`))),null):{stack:{bottom:{kind:`codes`,latents:Gt(r.texture)},coats:[]},rotation:0,texture:r}}function ec({bottom:e,name:t},{coats:n}){if(e.kind!==`codes`||e.table===void 0||n.length>0)return;let{table:r,besideLobe:i=!1}=e,a=ri.value.get(r);if(a!==void 0)return{logs:a,besideLobe:i};Zs().then(()=>{ri.peek().has(r)||q(new I(`${tc(`table of “${t}”`)} It is shown by its codes.`))})}function tc(e){return`The ${e} is no part of the address or the state; open its file again.`}function nc(e,t){Is.value=new Map(Is.peek()).set(e,t),Rr({...U.peek(),object:`own`,mesh:e})}function rc(e,t){Fs.value=new Map(Fs.peek()).set(e,t);let{environment:n,panorama:r}=U.peek();(n!==`own`||r!==e)&&Rr({...U.peek(),environment:`own`,panorama:e})}var ic=6e4,ac=N([]);async function oc(e){Or.value=null;for(let t of e)try{await sc(t)}catch(e){q(e,()=>void oc([t]),`“${t.name}” was not opened. `)}}async function sc(e){let t=await uc(e),n=e.name.toLowerCase().split(`.`).pop();if(n===`hdr`||n===`exr`){let r=n===`hdr`?nn(t):await dc(t);rc(e.name,{file:e,...ln(r)})}else if(n===`obj`||n===`glb`||n===`gltf`)nc(e.name,await Ar(`Reading the mesh`,(e,r)=>Gi(e=>e.readMesh(t,n,r),e)));else if(n===`json`)Rr(pr(hc(t),Hr));else if(n===`mtlx`){let{bottom:n,coats:r,lost:i}=Ni(t);cc({name:lc(e),bottom:n,coats:r,solo:null}),i.length>0&&Hr(`“${e.name}” was opened without ${i.join(`, `)}; urushi convert writes all of it as a Mitsuba scene.`)}else if(n===`safetensors`||n===`binary`||n===`bsdf`){let r=X.value?.cores;if(r===void 0)throw new I(`The networks are not loaded yet.`);let i=await fc(r,t,n!==`safetensors`);cc({name:lc(e),...i,coats:[],solo:null})}else throw new I(`The page opens materials (.safetensors, .mtlx), measured BRDFs (.binary of MERL, .bsdf of RGL), panoramas (.hdr, .exr), meshes (.obj, .glb, .gltf) and saved states (.json).`)}function cc(e){ac.value=[e,...ac.value.filter(({name:t})=>t!==e.name)],G(e)}function lc(e){return e.name.replace(/\.[a-z]+$/i,``).slice(0,80)}async function uc(e){try{return new Uint8Array(await e.arrayBuffer())}catch{throw new I(`It is a folder, or the browser cannot read it.`)}}async function dc(e){let t=new Promise((e,t)=>{setTimeout(()=>t(new I(`This .exr file is damaged.`)),ic)}),n=await Ar(`Reading the panorama`,n=>Gi(n=>Promise.race([n.readExr(e),t]),n));return rn(n.width,n.height),n}async function fc(e,t,n){let r=e.isotropic;return n?{bottom:await pc(r,t)}:Ut(t)?{bottom:{kind:`texels`,texture:await ni(t,r)}}:ui(t,li(t)===r.fingerprint?r:await e.anisotropic())}async function pc(e,t){kr.value={text:`Encoding the measured BRDF`},Nr(`The measured BRDF is being encoded.`);try{let{latents:n,table:r}=await e.encodeMeasured(t.buffer);return{kind:`codes`,latents:n,table:ii(r.logs)}}finally{kr.value=null}}function mc(e){e.addEventListener(`dragover`,t=>{t.preventDefault(),e.classList.add(`dropping`)}),e.addEventListener(`dragleave`,t=>{t.relatedTarget===null&&e.classList.remove(`dropping`)}),e.addEventListener(`drop`,t=>{t.preventDefault(),e.classList.remove(`dropping`);let n=[...t.dataTransfer?.files??[]];n.length>0?oc(n):q(new I(`What was dropped is no file; save it as a file, and drop that.`))})}function hc(e){try{return JSON.parse(new TextDecoder(`utf-8`,{fatal:!0}).decode(e))}catch{throw new I(`It is no JSON text.`)}}var[gc,_c]=[`u1`,`u2`];function vc(e,t){return JSON.stringify(e,(e,t)=>t instanceof Float32Array?Array.from(t,e=>Number(e.toPrecision(8))):t,t)}function yc(e){let t=new TextEncoder().encode(vc(e));return`${_c}.${xc(t)}.${Sc(t)}`}function bc(e,t){let[n,r,i,...a]=e.replace(/^#/,``).split(`.`);if(n!==_c&&n!==gc)throw new I(`The address was made by another version of this page.`);let o=a.length===0&&r&&i?Cc(i):null;if(o===null||xc(o)!==r)throw new I(`The address is incomplete; copy it again, up to its end.`);return pr(JSON.parse(new TextDecoder().decode(o)),t)}function xc(e){return Vt(e).toString(36)}function Sc(e){let t=``;for(let n of e)t+=String.fromCharCode(n);return btoa(t).replaceAll(`+`,`-`).replaceAll(`/`,`_`).replace(/=+$/,``)}function Cc(e){try{let t=atob(e.replaceAll(`-`,`+`).replaceAll(`_`,`/`));return Uint8Array.from(t,e=>e.charCodeAt(0))}catch{return null}}function wc(e){let t=Math.min(Math.max(e,0),1);return t<=.0031308?12.92*t:1.055*t**(1/2.4)-.055}function Tc(e){return e<=.04045?e/12.92:((e+.055)/1.055)**2.4}function Ec(e){return`#${e.map(e=>Math.round(255*wc(e)).toString(16).padStart(2,`0`)).join(``)}`}function Dc(e){let[t,n,r]=[1,3,5].map(t=>{let n=Tc(Number.parseInt(e.slice(t,t+2),16)/255);return Number(n.toFixed(3))});return[t,n,r]}var Oc=Symbol.for(`pv`),kc=0;Array.isArray;function Z(t,n,r,i,a,o){n||={};var s,c,l=n;if(`ref`in l&&typeof t!=`function`)for(c in l={},n)c==`ref`?s=n[c]:l[c]=n[c];var u={type:t,props:l,key:r,ref:s,__k:null,__:null,__b:0,__e:null,__c:null,constructor:Oc,__v:--kc,__i:-1,__u:0};return(a||o)&&(u.__source=a,u.__self=o),e.vnode&&e.vnode(u),u}function Ac({name:e,value:t,low:n,high:r,onChange:i}){let a=mt(null),o=()=>{let e=a.value;if(a.value=null,e===null||e.trim()===``)return;let o=Number(e.replace(`,`,`.`));Number.isFinite(o)&&o!==t&&i(Math.min(Math.max(o,n),r))},s=(e,a)=>{let o=Number((t+(t>=1?.1:t>=.1?.01:.001)*(a?10:1)*e).toFixed(4));i(Math.min(Math.max(o,n),r))};return Z(`input`,{type:`text`,inputMode:`decimal`,class:`number`,autocomplete:`off`,spellcheck:!1,"aria-label":e,value:a.value??jc(t),onInput:e=>{let t=a.value!==null;a.value=e.currentTarget.value,!t&&e.inputType.startsWith(`history`)&&o()},onFocus:e=>e.currentTarget.select(),onBlur:o,onKeyDown:e=>{e.key===`Enter`?o():e.key===`Escape`?a.value=null:(e.key===`ArrowUp`||e.key===`ArrowDown`)&&(e.preventDefault(),s(e.key===`ArrowUp`?1:-1,e.shiftKey))}})}function jc(e){return String(Number(e.toPrecision(4)))}var Mc=6;function Nc({name:e,text:t,low:n,high:r,step:i,value:a,onInput:o,...s}){let c=A(null),l=(e,t)=>{c.current=null,e.value=String(t),o(t)};return Z(`input`,{type:`range`,class:`${s.class??``} ${s.track?`graded`:``}`,"aria-label":e,"aria-valuetext":t,min:n,max:r,step:i,value:a,style:{"--fill":`${(100*(a-n)/(r-n)).toFixed(2)}%`,"--graded":s.track},onPointerDown:({pointerType:e,clientX:t,clientY:n})=>{c.current=e===`touch`?{x:t,y:n,value:a}:null},onInput:({currentTarget:e})=>{if(c.current===null)return o(Number(e.value));c.current.value=Number(e.value),e.value=String(a)},onPointerMove:({currentTarget:e,clientX:t,clientY:n})=>{if(c.current===null)return;let r=Math.abs(t-c.current.x);r>=Mc&&r>Math.abs(n-c.current.y)&&l(e,c.current.value)},onPointerUp:({currentTarget:e})=>{c.current!==null&&l(e,c.current.value)},onPointerCancel:()=>{c.current=null},onDblClick:s.onReset,onKeyDown:e=>{(e.key===`Delete`||e.key===`Backspace`)&&s.onReset()}})}var Pc=[`red`,`green`,`blue`];function Fc(e){let{owner:t,parameter:n,value:r,coloured:i,aside:a,colourOf:o,onChange:s}=e,c=typeof r!=`number`,l=z(r),u=`${t}, ${n.label}`,d=()=>s(n.fallback,``),f=(e,t)=>{if(e===null)return s(t,u);let n=[...l];n[e]=t,s(n,`${u} ${e}`)},p=()=>s(c?$n((l[0]+l[1]+l[2])/3):[...l],``),m=e=>{if(o!==void 0)return`linear-gradient(90deg, ${Lc.map(t=>{let r=Qn(n,t);return Ec(o(e===null?r:l.map((t,n)=>n===e?r:t)))}).join(`, `)})`};return Z(`div`,{class:c?`field split`:`field`,children:[Z(`span`,{class:`label`,title:`${n.hint} Double click: reset.`,onDblClick:d,children:n.label}),Z(`span`,{class:`aside`,children:[a,n.isColour&&Z(zc,{name:u,values:l,onChange:s}),i&&Z(`button`,{type:`button`,class:`channels`,"aria-pressed":c,"aria-label":`${u}: one value for each colour`,title:c?`One value for all colours`:`One value for each colour`,onClick:p,children:[Z(`i`,{}),Z(`i`,{}),Z(`i`,{})]})]}),Z(`div`,{class:`rows`,children:c?Pc.map((e,t)=>Z(Rc,{name:`${u}, ${e}`,channel:e,track:m(t),parameter:n,value:l[t],onInput:e=>f(t,e),onReset:d},e)):Z(Rc,{name:u,track:m(null),parameter:n,value:l[0],onInput:e=>f(null,e),onReset:d})})]})}var Ic=500,Lc=[0,.2,.4,.6,.8,1];function Rc({name:e,channel:t,track:n,parameter:r,value:i,onInput:a,onReset:o}){return Z(`div`,{class:`row`,children:[Z(Nc,{class:t??``,track:n,name:e,text:String(i),low:0,high:Ic,step:1,value:Math.round(Zn(r,i)*Ic),onInput:e=>a(Qn(r,e/Ic)),onReset:o}),Z(Ac,{name:`${e}, number`,value:i,low:r.low,high:r.high,onChange:e=>a(Xn(r,e))})]})}function zc({name:e,values:t,onChange:n}){return Z(`input`,{type:`color`,class:`swatch`,"aria-label":`${e}: choose`,title:`Choose the colour`,value:Ec(t),onInput:t=>n(yn(Dc(t.currentTarget.value)),`${e} colour`)})}var Bc={...V,view:{...V.view,elevation:12,zoom:1.2},slot:0},Vc=new WeakMap,Hc=[],Uc=null;function Wc(e){let t=Vc.get(e);return t===void 0&&(t=new Promise(t=>{Hc.push(()=>Kc(e).then(t,()=>t(null)))}),Vc.set(e,t),Hc.length===1&&Gc()),t}async function Gc(){for(;Hc.length>0;Hc.shift())await Hc[0]();Uc?.dispose(),Uc=null}async function Kc(e){for(;X.peek()===null;)await new Promise(e=>setTimeout(e,100));let t=$s(e);if(t===null)return null;let n=await X.peek().cores.of(t.stack),r=await n.layer(t.stack),i={...r,table:t.table??r.table},a={...oo[n.widths],samples:128},o=await n.table(i,{...a,shift:[0,0,0]});if(Uc===null){let e=document.createElement(`canvas`);[e.width,e.height]=[112,112],Uc=new hs(e),Uc.setEnvironment(`studio`,null)}return Uc.setTexels(0,t.texture),Uc.setTable(0,o,a,t.rotation,!0),Uc.draw(Bc),createImageBitmap(Uc.picture)}function qc({of:e}){let t=A(null);return Ae(()=>{let n=!0;return Wc(e).then(e=>{n&&e!==null&&t.current?.getContext(`2d`)?.drawImage(e,0,0)}),()=>{n=!1}},[e]),Z(`canvas`,{ref:t,width:112,height:112,"aria-hidden":`true`})}function Jc({owner:e,parameter:t,widths:n,onChange:r}){let{alpha:i,alphaV:a}=n,o=a===void 0,s=Z(`button`,{type:`button`,class:`link`,"aria-pressed":!o,"aria-label":`${e}, u·v: two widths`,title:o?`Two widths, along and across the tangent`:`One width`,onClick:()=>r({alpha:i,alphaV:o?i:void 0},``),children:`u·v`});return Z(x,{children:[Z(Fc,{owner:e,parameter:o?t:{...Gn.alpha,fallback:t.fallback},value:i,coloured:typeof i!=`number`,aside:s,onChange:(e,t)=>r({alpha:e,alphaV:a},t)}),!o&&Z(Fc,{owner:e,parameter:{...Gn.alphaV,fallback:t.fallback},value:a,coloured:typeof a!=`number`,onChange:(e,t)=>r({alpha:i,alphaV:e},t)})]})}function Yc(e,{alpha:t,alphaV:n}){let{alphaV:r,...i}=e;return{...i,alpha:t,...n===void 0?{}:{alphaV:n}}}var Xc={metal:`Metal by index`,schlick:`Metal by reflectance`,diffuse:`Matt (Lambertian)`,dielectric:`Dielectric`};function Zc({material:e,alone:t}){let{bottom:n}=e,r=tl(n),{name:i}=e,a=je(()=>({name:i,bottom:n,coats:[],solo:null}),[i,n]),o=(t,n=``)=>G({...e,bottom:t},n);return Z(`section`,{class:`card bottom`,"aria-label":`Bottom`,style:{"--medium":Ec(On(n))},children:[Z(`header`,{children:[Z(`span`,{class:`title`,children:`Bottom`}),Z(`select`,{"aria-label":`Kind of bottom`,value:r,onChange:e=>o(il(e.currentTarget.value,n)),children:[Object.entries(Xc).map(([e,t])=>Z(`option`,{value:e,children:t},e)),r===`codes`&&Z(`option`,{value:`codes`,children:`Loaded material`}),r===`texels`&&Z(`option`,{value:`texels`,children:`Loaded texture`})]}),Z(`button`,{type:`button`,class:`icon-button solo`,"aria-label":`Solo the bottom`,"aria-pressed":t,title:`Show the bottom without coats`,onClick:()=>G({...e,solo:t?null:0}),children:`S`})]}),Z(`div`,{class:`fields`,children:[r===`metal`&&Z($c,{bottom:n,onChange:o}),`alpha`in n&&Z(Jc,{owner:`Bottom`,parameter:Yn.alpha,widths:n,onChange:(e,t)=>o(Yc(n,e),t)}),nl(n).map(([e,t])=>Z(Fc,{owner:`Bottom`,parameter:t,value:n[e],coloured:r!==`dielectric`,colourOf:t=>On({...n,[e]:t}),onChange:(t,r)=>o({...n,[e]:t},r)},e)),(n.kind===`codes`||n.kind===`texels`)&&Z(`div`,{class:`loaded`,children:[Z(qc,{of:a}),Z(`p`,{class:`note`,children:[Z(`strong`,{children:i}),` `,Qc(n)]})]})]})]})}function Qc(e){if(e.kind===`texels`)return`was loaded from a file with a texture; coat it in Python. The plots show its mean code.`;let t=`was loaded from a file; its own coats keep their ratios of indices.`;return e.table===void 0?t:`${t} It is shown by its table, but under coats by its codes, which can differ from it by 10 to 40 %.`}function $c({bottom:e,onChange:t}){let n=Object.entries(tr).find(([,t])=>`k`in e&&el(z(e.eta),t.eta)&&el(z(e.k),t.k));return Z(`div`,{class:`chips`,role:`group`,"aria-label":`Metals`,children:Object.entries(tr).map(([r,{eta:i,k:a}])=>Z(`button`,{type:`button`,"aria-pressed":n?.[0]===r,style:{"--medium":Ec(On({kind:`conductor`,alpha:0,eta:i,k:a}))},onClick:()=>t({kind:`conductor`,...rl(e),eta:i,k:a}),children:r},r))})}function el(e,t){return e.every((e,n)=>Math.abs(e-t[n])<1e-6)}function tl(e){return e.kind===`conductor`?`r0`in e?`schlick`:`metal`:e.kind}function nl(e){let{r0:t,eta:n,k:r,reflectance:i}=Yn;switch(tl(e)){case`metal`:return[[`eta`,n],[`k`,r]];case`schlick`:return[[`r0`,t]];case`dielectric`:return[[`ior`,Jn.ior]];case`diffuse`:return[[`reflectance`,i]];case`codes`:case`texels`:return[]}}function rl(e){if(!(`alpha`in e))return{alpha:Yn.alpha.fallback};let{alpha:t,alphaV:n}=e;return n===void 0?{alpha:t}:{alpha:t,alphaV:n}}function il(e,t){let n=rl(t),r=On(t);switch(e){case`metal`:return{kind:`conductor`,...n,...tr.Gold};case`schlick`:return{kind:`conductor`,...n,r0:`k`in t?r:.9};case`dielectric`:return{kind:`dielectric`,...n,ior:1.5};case`diffuse`:return{kind:`diffuse`,reflectance:r};case`codes`:case`texels`:return t}}var[al,ol]=R.TRAINED_G,{DEEPEST:sl}=pn;function cl(e){let t={alpha:R.MIN_ALPHA,alphaV:R.MIN_ALPHA},n=e.eta===1?{...e,...t}:e,r=Math.min(Math.max(n.g,al),ol);if(r===n.g&&n.sigmaT<=sl)return n;let i=n.sigmaT*(1-n.albedo),a=n.sigmaT*n.albedo*(1-n.g);if(i+a/(1-r)>sl){let e=1-a/Math.max(sl-i,1e-6);r=Math.min(Math.max(e,Math.min(r,0)),r)}let o=a/(1-r),s=i+o,c=s>0?o/s:n.albedo;return{...n,albedo:c,sigmaT:Math.min(s,sl),g:r}}function ll(e,t){let n=typeof e==`number`?e:e[t];return Math.fround(n??NaN)+0}function ul(e,t){return{alpha:ll(e.alpha,t),alphaV:ll(e.alphaV??e.alpha,t),eta:ll(e.eta,t),albedo:ll(e.albedo,t),sigmaT:ll(e.sigmaT,t),g:ll(e.g,t)}}var dl={undo:`M6 3 3 6l3 3M3 6h6.5a3.5 3.5 0 0 1 0 7H6`,redo:`m10 3 3 3-3 3m3-3H6.5a3.5 3.5 0 0 0 0 7H10`,plus:`M8 3v10M3 8h10`,cross:`m4 4 8 8m0-8-8 8`,grip:`M6 4v.01M10 4v.01M6 8v.01M10 8v.01M6 12v.01M10 12v.01`,eye:`M1.5 8S4 3.5 8 3.5 14.5 8 14.5 8 12 12.5 8 12.5 1.5 8 1.5 8ZM8 10a2 2 0 1 0 0-4 2 2 0 0 0 0 4Z`,hidden:`m2 2 12 12M6.5 3.700A6 6 0 0 1 8 3.5c4 0 6.5 4.5 6.5 4.5a12 12 0 0 1-2 2.5M4 5a12 12 0 0 0-2.5 3S4 12.5 8 12.5a6 6 0 0 0 2.5-.55`,down:`m4 6 4 4 4-4`,save:`M8 2v8m-3-3 3 3 3-3M3 12.5h10`,open:`M2.5 12.5v-9h4l1.5 2h5.5v7Z`,sliders:`M2 5h6m3 0h3M2 11h3m3 0h6M9.500 6.500a1.500 1.500 0 1 0 0-3 1.500 1.500 0 0 0 0 3ZM6.500 12.500a1.500 1.500 0 1 0 0-3 1.500 1.500 0 0 0 0 3Z`,swap:`M3 6h9.5L10 3.5M13 10H3.5L6 12.5`};function Q({name:e}){return Z(`svg`,{class:`icon`,viewBox:`0 0 16 16`,"aria-hidden":`true`,focusable:`false`,children:Z(`path`,{d:dl[e]})})}var fl=N(new Set),pl=N(new Set);function ml(e,t){let n=new Set(e);return n.delete(t)||n.add(t),n}function hl({card:e,name:t,seen:n,dragged:r,onMove:i,onDrag:a}){let o=fl.value.has(e.id),s=W.value.solo===e.id,c=(t,n)=>{let r=W.value.coats.map(n=>n.id===e.id?t:n);G({...W.value,coats:r},n)},l=(t,n=``)=>c({...e,...t},n),u=Sn(e),d=Dn(W.value,e),f={card:e,owner:t,onChange:c};return Z(`li`,{class:[`card`,n?``:`unseen`,r?`dragged`:``].join(` `),"aria-label":t,style:{"--medium":Ec(xl(e))},children:[Z(`header`,{children:[Z(`button`,{type:`button`,class:`icon-button grip`,"aria-label":`Move ${t}: arrow keys, or drag`,title:`Drag, or use the arrow keys`,onPointerDown:a,onKeyDown:e=>{let t={ArrowUp:-1,ArrowDown:1}[e.key];if(t===void 0)return;e.preventDefault(),i(t);let n=e.currentTarget;requestAnimationFrame(()=>n.focus())},children:Z(Q,{name:`grip`})}),Z(`button`,{type:`button`,class:`title`,"aria-expanded":!o,onClick:()=>{fl.value=ml(fl.value,e.id)},children:[Z(`span`,{children:t}),Z(`small`,{children:bl(e,d)})]}),Z(`button`,{type:`button`,class:`icon-button solo`,"aria-label":`Solo ${t}`,"aria-pressed":s,title:`Show this coat alone over the bottom`,onClick:()=>G({...W.value,solo:s?null:e.id}),children:`S`}),Z(`button`,{type:`button`,class:`icon-button eye`,"aria-label":`Show ${t}`,"aria-pressed":e.on,title:e.on?`Switch off`:`Switch on`,onClick:()=>l({on:!e.on}),children:Z(Q,{name:e.on?`eye`:`hidden`})}),Z(`button`,{type:`button`,class:`icon-button`,"aria-label":`Remove ${t}`,title:`Remove`,onClick:()=>{G(Un(W.value,e.id)),Nr(`${t} was removed.`)},children:Z(Q,{name:`cross`})})]}),!o&&Z(`div`,{class:`fields`,children:[Z(_l,{name:`color`,...f}),Z(_l,{name:`body`,...f}),Math.max(...z(u.body))>0&&Z(_l,{name:`bodyColor`,...f}),Z(_l,{name:`thickness`,...f}),d?Z(Jc,{owner:t,parameter:Jn.alpha,widths:e,onChange:(t,n)=>c(Yc(e,t),n)}):Z(`p`,{class:`note`,children:`No surface, so no roughness: its index n is that of the coat above.`}),Z(`details`,{open:pl.value.has(e.id),onToggle:({currentTarget:{open:t}})=>{t!==pl.value.has(e.id)&&(pl.value=ml(pl.value,e.id))},children:[Z(`summary`,{children:`Physical`}),Z(Fc,{owner:t,parameter:Jn.ior,value:e.ior,coloured:typeof e.ior!=`number`,onChange:(e,t)=>l({ior:e},t)}),Z(_l,{name:`sigmaT`,...f}),Z(_l,{name:`albedo`,...f}),Z(_l,{name:`g`,...f}),Z(gl,{card:e})]})]})]})}function gl({card:e}){let{albedo:t,sigmaT:n}=xn(e),r={alpha:1,eta:1.5,albedo:t,g:e.g},i=[0,1,2].map(t=>{let i=z(n)[t]*(e.thickness??1),a=ul({...r,sigmaT:i},t),o=cl(a);return o===a?null:$n(o.sigmaT)});return i.every(e=>e===null)?null:Z(`p`,{class:`note`,children:[`A medium that looks alike is shown, of depth `,[...new Set(i.filter(e=>e!==null))].join(`, `),`.`]})}function _l({name:e,card:t,owner:n,onChange:r}){let i=n=>yl(t,e,n);return Z(Fc,{owner:n,parameter:Jn[e],value:vl(t,e),coloured:e!==`thickness`,colourOf:e===`g`?void 0:e=>xl(i(e)),onChange:(e,t)=>r(i(e),t)})}function vl(e,t){return t===`thickness`?e.thickness??1:B({...Sn(e),...xn(e),g:e.g}[t],$n)}function yl(e,t,n){if(t===`thickness`)return{...e,thickness:z(n)[0]};if(t===`g`)return{...e,g:n};let{color:r,body:i,bodyColor:a,albedo:o,sigmaT:s,...c}=e,l=t===`albedo`||t===`sigmaT`?xn(e):Sn(e),u=Object.entries(l).map(([e,t])=>[e,B(t,$n)]);return{...c,...Object.fromEntries(u),[t]:n}}function bl(e,t){let{color:n,body:r}=Sn(e),i=Math.max(...z(r)),a=Math.max(...z(e.alpha),...z(e.alphaV??e.alpha)),o=t?a>.2?`matt`:`glossy`:`no surface`;return i>.6?`${o}, opaque`:i>.02?`${o}, milky`:Math.min(...z(n))>.99?`${o}, clear`:`${o}, tinted`}function xl(e){return wn(e,e.thickness??1)}var Sl=N(null);function Cl(){let e=A(null),{coats:t,solo:n}=W.value,r=(e,n)=>{n<0||n>=t.length||e===n||(G(Vn(W.value,e,n),`move ${t[e].id}`),Nr(`Coat moved to place ${n+1} of ${t.length}.`))},i=(t,n)=>{if(t.button!==0||e.current===null)return;let r=t.currentTarget;r.setPointerCapture(t.pointerId),Sl.value=n.id;let i=t=>{let r=W.value.coats.findIndex(e=>e.id===n.id),i=[...e.current?.children??[]].map(e=>e.getBoundingClientRect()),a=i[r-1],o=i[r+1],s=i[r];s!==void 0&&(a&&t.clientY<a.top+Math.min(a.height/2,s.height)?G(Vn(W.value,r,r-1),`move ${n.id}`):o&&t.clientY>o.bottom-Math.min(o.height/2,s.height)&&G(Vn(W.value,r,r+1),`move ${n.id}`))},a=()=>{Sl.value=null,r.removeEventListener(`pointermove`,i),r.removeEventListener(`lostpointercapture`,a)};r.addEventListener(`pointermove`,i),r.addEventListener(`lostpointercapture`,a)};return Z(`section`,{class:`cards`,"aria-label":`Stack of layers`,children:[Z(`div`,{class:`cards-head`,children:[Z(`h2`,{children:`Layers`}),Z(`button`,{type:`button`,class:`quiet`,"aria-disabled":!zn(W.value),title:zn(W.value)?`Add a clear coat on top`:`Six coats are the most, and a texture of codes has none`,onClick:()=>{zn(W.value)&&(G(Hn(W.value)),Nr(`A coat was added on top.`))},children:[Z(Q,{name:`plus`}),` Add coat`]})]}),Z(`ul`,{ref:e,"aria-label":`Coats, the topmost first`,children:t.map((e,n)=>Z(hl,{card:e,name:`Coat ${t.length-n}`,seen:kn(W.value,e),dragged:Sl.value===e.id,onMove:e=>r(n,n+e),onDrag:t=>i(t,e)},e.id))}),Z(Zc,{material:W.value,alone:n===0}),t.length>0&&Z(`label`,{class:`switch`,title:`Light that meets a second facet of the topmost coat is given back`,children:[Z(`input`,{type:`checkbox`,checked:W.value.energyCompensation===!0,onChange:({currentTarget:{checked:e}})=>G({...W.value,energyCompensation:e})}),`Energy compensation`]}),Ln(W.value)&&Z(`div`,{class:`fields tangent`,children:Z(Fc,{owner:`Material`,parameter:Kn,value:W.value.rotation??0,coloured:!1,onChange:(e,t)=>G({...W.value,rotation:z(e)[0]},t)})})]})}var wl=N(!1),Tl=N(``),El=`Tap, point at or focus anything: its explanation appears here.`;function Dl(e){let t=e.closest(`[title], .field`);return(t?.hasAttribute(`title`)?t:t?.querySelector(`.label`))?.getAttribute(`title`)??``}function Ol(){return Z(`button`,{type:`button`,class:`icon-button help`,"aria-label":`Explain the page`,"aria-pressed":wl.value,title:`Explains what you tap, point at or focus`,onClick:()=>{wl.value=!wl.value,Tl.value=El},children:`?`})}function kl(){return Ae(()=>{let e=({target:e})=>{wl.value&&e instanceof Element&&(Tl.value=Dl(e)||El)},t=[`pointerover`,`pointerdown`,`focusin`];for(let n of t)document.addEventListener(n,e);return()=>{for(let n of t)document.removeEventListener(n,e)}},[]),Z(`p`,{class:`explanation`,role:`status`,hidden:!wl.value,children:wl.value&&Tl.value})}var Al=[`red`,`green`,`blue`];function jl(){let e=X.value?.slots[U.value.active];return Z(`section`,{class:`plots`,"aria-label":`Plots`,children:Z(`details`,{open:U.value.plots,onToggle:({currentTarget:{open:e}})=>{e!==U.value.plots&&K({plots:e})},children:[Z(`summary`,{children:`Plots`}),Z(`div`,{children:[Z(Pl,{slot:e}),Z(Vl,{slot:e})]})]})})}var Ml=120;function Nl(e){let t=Math.max(1,...e??[]),n=10**Math.ceil(Math.log10(t)-.02),r=.01,i=e=>Ml*Math.log(1+Math.max(e,0)/r)/Math.log(1+n/r),a=[];for(let e=n;e>.05;e/=10)a.push(Number(e.toPrecision(1)));return{radius:i,rings:a}}function Pl({slot:e}){let t=A(null),n=A(null),r=A(!1),{incidence:i}=U.value,a=e?.plane.value??null,o=e?.walk.value??null,{radius:s,rings:c}=Nl(a),l=i*Math.PI/180,[u,d]=[-120*Math.sin(l),-120*Math.cos(l)],f=e=>{let n=t.current?.getScreenCTM();if(!n)return;let r=new DOMPoint(e.clientX,e.clientY).matrixTransform(n.inverse()),i=Math.atan2(-r.x,Math.max(-r.y,0))*180/Math.PI;K({incidence:Math.round(Math.min(Math.max(i,0),89))})};return Z(`figure`,{children:[Z(`figcaption`,{children:[Z(`b`,{children:`f in the plane of incidence`}),` [1/sr]`,Z(Il,{comparison:o})]}),Z(`svg`,{ref:t,viewBox:`-150 -136 300 152`,role:`group`,"aria-label":`Plot of f in the plane of incidence`,onPointerDown:e=>{r.current=e.pointerType!==`touch`||e.target===n.current,r.current&&(e.currentTarget.setPointerCapture(e.pointerId),f(e))},onPointerMove:e=>{r.current&&f(e)},onLostPointerCapture:()=>{r.current=!1},children:[Z(`g`,{class:`grid`,children:[c.map(e=>Z(`g`,{children:[Z(`path`,{d:Ll(s(e))}),Z(`text`,{x:s(e)-2,y:11,"text-anchor":`end`,children:e})]},e)),Z(`path`,{d:`M-120 0H${Ml}M0 0V-120`})]}),a!==null&&Al.map((e,t)=>Z(`path`,{class:`curve ${e}`,d:Rl(a,t,s)},e)),o!==null&&Z(Fl,{comparison:o,radius:s}),Z(`line`,{class:`incident`,x1:0,y1:0,x2:u,y2:d}),Z(`circle`,{class:`knob`,cx:u,cy:d,r:7}),Z(`circle`,{ref:n,class:`handle`,cx:u,cy:d,r:14,tabindex:0,role:`slider`,"aria-label":`Angle of incidence`,"aria-valuemin":0,"aria-valuemax":89,"aria-valuenow":i,"aria-valuetext":`${i} degrees`,onKeyDown:e=>{let t={ArrowLeft:1,ArrowUp:-1,ArrowRight:-1,ArrowDown:1}[e.key];if(t===void 0)return;e.preventDefault();let n=i+t*(e.shiftKey?10:1);K({incidence:Math.min(Math.max(n,0),89)})}}),Z(`text`,{class:`value`,x:u<-60?u+4:u-12,y:d-11,"text-anchor":`middle`,children:[i,`°`]})]})]})}function Fl({comparison:e,radius:t}){return Z(`g`,{children:Al.map((n,r)=>Array.from(uo,(i,a)=>{let o=i*Math.PI/180,s=t(e.f[3*a+r]),c=`${n}${a}`;return Z(`circle`,{class:`dot ${n}`,cx:s*Math.sin(o),cy:-s*Math.cos(o),r:1.7},c)}))})}function Il({comparison:e}){if(e===null||!Number.isFinite(e.whole.noise))return null;let t=e=>`${(100*e).toFixed(1)}\u00a0%`,{whole:n,rest:r}=e;return Z(`span`,{class:`difference`,title:`The random walk is the reference. Its noise falls as it goes on, and bounds what can be said. The highlight of the topmost surface is exact, and most of the light here: the second number leaves it out.`,children:[` · `,t(n.deviation),` from the walk ±\xA0`,t(n.noise),Number.isFinite(r.noise)&&Z(x,{children:[`, without the highlight `,t(r.deviation),` ±\xA0`,t(r.noise)]})]})}function Ll(e){let t=e.toFixed(1);return`M-${t} 0A${t} ${t} 0 0 1 ${t} 0`}function Rl(e,t,n){return`M${Array.from(lo,(r,i)=>{let a=r*Math.PI/180,o=n(e[3*i+t]);return`${(o*Math.sin(a)).toFixed(1)} ${(-o*Math.cos(a)).toFixed(1)}`}).join(`L`)}`}var zl=230,Bl=104;function Vl({slot:e}){let t=e?.albedo.value??null,{incidence:n}=U.value,r=e=>zl*e/90;return Z(`figure`,{children:[Z(`figcaption`,{children:[Z(`b`,{children:`Directional albedo`}),` by angle of incidence`]}),Z(`svg`,{viewBox:`-34 -14 280 142`,role:`img`,"aria-label":Ul(t),children:[Z(`g`,{class:`grid`,children:[[0,.25,.5,.75,1].map(e=>Z(`path`,{d:`M0 ${Bl*(1-e)}H${zl}`},e)),[0,.5,1].map(e=>Z(`text`,{x:-6,y:Bl*(1-e)+3,"text-anchor":`end`,children:e},e)),[0,30,60,90].map(e=>Z(`text`,{x:r(e),y:119,"text-anchor":`middle`,children:[e,`°`]},e))]}),Z(`line`,{class:`incident`,x1:r(n),x2:r(n),y1:0,y2:Bl}),t!==null&&Al.map((e,n)=>Z(`path`,{class:`curve ${e}`,d:Hl(t,n,r)},e))]})]})}function Hl(e,t,n){return`M${Array.from(so,(r,i)=>{let a=n(r),o=Bl*(1-Math.min(e[3*i+t],1.1));return`${a.toFixed(1)} ${o.toFixed(1)}`}).join(`L`)}`}function Ul(e){if(e===null)return`Directional albedo`;let t=t=>[0,1,2].map(n=>`${Math.round(100*e[3*t+n])}`).join(`, `);return`Directional albedo in percent, red, green and blue: ${t(0)} near the normal, ${t(13)} at grazing incidence`}var Wl=`stage`;function Gl(){let{comparison:e,materials:t,background:n}=U.value;return Z(`section`,{id:Wl,class:n===`transparent`?`stage checkered`:`stage`,"aria-label":`Picture`,children:[Z(ql,{}),(e===`side`||e===`swipe`)&&Z(`div`,{class:`names ${e}`,children:[Z(`span`,{children:[`A · `,rr(t[0])]}),Z(`span`,{children:[`B · `,rr(t[1])]})]}),e===`swipe`&&Z(ru,{}),e===`difference`&&Z(nu,{}),Us.value===``?Z(tu,{}):Z(`p`,{class:`missing`,children:Us.value}),Z(Kl,{})]})}function Kl(){if(Or.value===null)return null;let{text:e,retry:t}=Or.value,n=()=>{Or.value=null};return Z(`div`,{class:`notice`,role:`alert`,children:[Z(`span`,{children:e}),t&&Z(`button`,{type:`button`,onClick:()=>{n(),t()},children:`Try again`}),Z(`button`,{type:`button`,onClick:n,children:`Close`})]})}function ql(){let e=A(null),{current:t}=A(new Map),n=X.value;Ae(()=>e.current&&n?n.attach(e.current):void 0,[n]),Ae(()=>{let t=e.current,n=e=>{e.preventDefault();let t=e.deltaY*(e.ctrlKey?6:1);Zl({zoom:U.value.view.zoom*2**(-t/600)})};return t.addEventListener(`wheel`,n,{passive:!1}),()=>t.removeEventListener(`wheel`,n)},[]);let{object:r,mesh:i,environment:a,turntable:o,comparison:s,materials:c,active:l}=U.value,u=s===`off`?rr(c[l]):`${rr(c[0])} beside ${rr(c[1])}`;return Ae(()=>{if(!o)return;let e=setInterval(()=>{Xl()?K({turntable:!1}):t.size===0&&Zl({azimuth:U.value.view.azimuth+Jl})},Yl);return()=>clearInterval(e)},[o,t]),Z(`canvas`,{ref:e,tabIndex:0,role:`img`,"aria-label":`${r===`own`?i:`A ${r}`} of ${u}, lit by the environment “${a}”. Arrow keys turn the camera, with Control they shift the picture, with Shift they turn the light; plus and minus zoom; Home or a double click resets the camera.`,onContextMenu:e=>e.preventDefault(),onPointerDown:({button:e,currentTarget:n,pointerId:r,clientX:i,clientY:a})=>{e!==1&&(n.setPointerCapture(r),t.set(r,[i,a]))},onLostPointerCapture:({pointerId:e})=>t.delete(e),onPointerMove:e=>{let{pointerId:n,clientX:r,clientY:i,currentTarget:a}=e,o=t.get(n);if(o===void 0)return;let{view:s}=U.value,[c,l]=[r-o[0],i-o[1]];t.set(n,[r,i]);let u=e=>{let t=e*2/(a.clientHeight*s.zoom);return[s.pan[0]+c*t,s.pan[1]-l*t]},d=[...t].find(([e])=>e!==n)?.[1];if(d!==void 0){let e=e=>Math.hypot(e[0]-d[0],e[1]-d[1])+1;Zl({zoom:s.zoom*e([r,i])/e(o),pan:u(.5)})}else e.buttons!==1||e.ctrlKey||e.metaKey?Zl({pan:u(1)}):e.shiftKey?Ql(c*.4):Zl({azimuth:s.azimuth-c*.4,elevation:s.elevation+l*.3})},onDblClick:()=>K({view:V.view}),onKeyDown:e=>{let{view:t}=U.value;e.key===`Home`&&K({view:V.view});let n={ArrowLeft:-1,ArrowRight:1}[e.key],r={ArrowUp:1,ArrowDown:-1}[e.key],i={"+":1.1,"=":1.1,"-":1/1.1}[e.key],[a,o]=t.pan;if((n??r)!==void 0&&(e.ctrlKey||e.metaKey))Zl({pan:[a+.1*(n??0),o+.1*(r??0)]});else if(n!==void 0&&e.shiftKey)Ql(5*n);else if(n!==void 0)Zl({azimuth:t.azimuth+5*n});else if(r!==void 0)Zl({elevation:t.elevation+5*r});else if(i!==void 0)Zl({zoom:t.zoom*i});else return;e.preventDefault()}})}var[Jl,Yl]=[.6,40];function Xl(){return matchMedia(`(prefers-reduced-motion: reduce)`).matches}function Zl(e){let t={...U.value.view,...e};K({view:{azimuth:eu(t.azimuth),elevation:Math.min(Math.max(t.elevation,-5),80),zoom:Math.min(Math.max(t.zoom,.5),4),fov:t.fov,pan:[$l(t.pan[0]),$l(t.pan[1])]}})}function Ql(e){let t=eu(U.value.rotation+e);Rr({...U.value,rotation:t},`rotation`)}function $l(e){return Number(Math.min(Math.max(e,-2),2).toFixed(3))}function eu(e){return Number((((e+180)%360+360)%360-180).toFixed(1))}function tu(){let e=X.value?.painter;if(kr.value!==null){let{text:e,share:t,cancel:n}=kr.value;return Z(`p`,{class:`status`,children:[t!==void 0&&Z(`progress`,{"aria-label":e,value:t}),e,` …`,n&&Z(`button`,{type:`button`,onClick:n,children:`Cancel`})]})}return e===void 0?Z(`p`,{class:`status`,children:Ws.value?`Loading the networks …`:`The networks are not loaded.`}):Z(`p`,{class:`status`,"data-converged":e.converged.value&&!Ls.value,children:[Z(`progress`,{"aria-hidden":`true`,value:e.gathered.value}),Ls.value?`computing shadows`:e.converged.value?`converged`:`refining`]})}function nu(){let{scale:e}=U.value,t=X.value?.painter.difference.value;return Z(`div`,{class:`legend`,children:[Z(`span`,{title:`Distance of the shown colours in CIELAB (CIE 1976); 2 is just seen`,children:`Colour difference`}),Z(`span`,{children:`0`}),Z(`div`,{class:`ramp`,"aria-hidden":`true`}),Z(`label`,{children:[Z(`span`,{class:`spoken`,children:`Largest difference`}),Z(`select`,{value:e,onChange:e=>K({scale:Number(e.currentTarget.value)}),children:lr.map(e=>Z(`option`,{value:e,children:e},e))})]}),t&&Z(`span`,{title:`Mean over the pixels that differ, and the largest difference`,children:[`mean `,t.mean.toFixed(1),`, largest `,t.largest.toFixed(1)]})]})}function ru(){let{edge:e}=U.value,t=e=>K({edge:Math.min(Math.max(e,.02),.98)});return Z(`div`,{class:`edge`,style:{left:`${100*e}%`},role:`slider`,tabIndex:0,"aria-label":`Edge between A and B`,"aria-orientation":`horizontal`,"aria-valuemin":0,"aria-valuemax":100,"aria-valuenow":Math.round(100*e),onPointerDown:e=>e.currentTarget.setPointerCapture(e.pointerId),onPointerMove:e=>{if(!e.currentTarget.hasPointerCapture(e.pointerId))return;let n=e.currentTarget.parentElement.getBoundingClientRect();t((e.clientX-n.left)/n.width)},onKeyDown:n=>{let r={ArrowLeft:-.02,ArrowRight:.02}[n.key];r!==void 0&&(n.preventDefault(),t(e+r))}})}function iu({label:e,hint:t,fallback:n=0,...r}){return Z(`label`,{title:t,children:[Z(`span`,{children:e}),Z(Nc,{...r,onReset:()=>r.onInput(n)}),Z(`output`,{children:r.text})]})}var au={off:`Single`,side:`Side by side`,swipe:`Swipe`,difference:`Difference`};function ou(){let{object:e,mesh:t,environment:n,panorama:r,rotation:i,exposure:a,comparison:o}=U.value,s=(e,t=``)=>Rr({...U.value,...e},t),c=t===``?ar:[...ar,`own`],l=or.filter(e=>e!==`own`||r!==``);return Z(`div`,{class:`toolbar`,role:`toolbar`,"aria-label":`Scene`,children:[Z(`label`,{children:[Z(`span`,{children:`Object`}),Z(`select`,{value:e,onChange:e=>s({object:e.currentTarget.value}),children:c.map(e=>Z(`option`,{value:e,children:e===`own`?t:su(e)},e))})]}),Z(`label`,{children:[Z(`span`,{children:`Light`}),Z(`select`,{value:n,onChange:e=>s({environment:e.currentTarget.value}),children:l.map(e=>Z(`option`,{value:e,children:e===`own`?r:su(e)},e))})]}),Z(iu,{label:`Turn`,hint:`Turns the light about the object. Double click: reset.`,text:`${Math.round(i)}°`,value:i,low:-180,high:180,step:1,onInput:e=>s({rotation:e},`rotation`)}),Z(iu,{label:`Exposure`,hint:`Brightness of the picture in powers of two. Double click: reset.`,text:`${a>0?`+`:``}${a}`,value:a,low:-4,high:4,step:.1,onInput:e=>s({exposure:Number(e.toFixed(1))},`exposure`)}),Z(`div`,{class:`segments`,role:`group`,"aria-label":`Compare`,children:cr.map(e=>Z(`button`,{type:`button`,"aria-pressed":o===e,onClick:()=>s({comparison:e}),children:au[e]},e))})]})}function su(e){return e[0].toUpperCase()+e.slice(1)}function cu({label:e,name:t,kind:n,children:r}){let i=mt(!1),a=A(null),o=A(null),s=()=>{i.value=!1,o.current?.focus()};return Ae(()=>{let e=e=>{a.current?.contains(e.target)||(i.value=!1)};return document.addEventListener(`pointerdown`,e),document.addEventListener(`focusin`,e),()=>{document.removeEventListener(`pointerdown`,e),document.removeEventListener(`focusin`,e)}},[i]),Z(`div`,{class:`menu ${n}`,ref:a,onKeyDown:e=>{e.key===`Escape`&&i.value&&s()},children:[Z(`button`,{type:`button`,ref:o,class:`opener`,"aria-label":t,"aria-expanded":i.value,onClick:()=>{i.value=!i.value},children:e}),i.value&&Z(`div`,{class:`panel`,children:r(s)})]})}var lu={dds:`DDS`,npy:`NPY`,exr:`EXR`},[uu,du,fu]=fn.SHAPE;function pu(e,t){let n=e.length/(4*uu*du);if(t===`exr`)return new Blob([Ts(gu(e,n))]);let r=t===`dds`?mu(n):hu(n);return new Blob([r,ai(e)])}function mu(e){let t=new Uint32Array(37);return t.set([542327876,124,8392719,du,e,8*e,uu,1]),t.set([32,4,808540228],19),t.set([4096,2097152],27),t.set([10,4,0,1,0],32),new Uint8Array(t.buffer)}function hu(e){let t=`{'descr': '<f2', 'fortran_order': False, 'shape': ${`(${uu}, ${du}, ${e}, 4)`}, }`.padEnd(117);return Uint8Array.of(147,...new TextEncoder().encode(`NUMPY\0v\0`),...new TextEncoder().encode(`${t}\n`))}function gu(e,t){let n=Math.ceil(4*t/fu/3),r=new Float32Array(uu*n*fu*du*3);for(let i=0;i<uu*du*fu;i++){let[a,o]=[Math.floor(i/fu),i%fu],[s,c]=[Math.floor(a/du),a%du];for(let i=0;i<4*t/fu;i++){let l=4*(a*t+Math.floor(i/4)*fu+o)+i%4,u=(s*n*fu+Math.floor(i/3)*fu+o)*du+c;r[3*u+i%3]=e[l]}}return{width:n*fu*du,height:uu,pixels:r}}function _u(e){let{name:t,rotation:n=0}=e,r=An(e),i=e.energyCompensation===!0&&r.coats.length>0,a=i&&Rn(r),o=[`import numpy as np`,``,`import urushi`,``,...a?[]:[`# The layers one by one by the layering network, as on the page. Without fast=True, light`,`# transport is computed, which takes longer and is closer to the random walk.`],`material = ${bu(r.bottom)}`];for(let e of r.coats.reverse()){let t=[...xu(e),[`ior`,e.ior]],n=e===r.coats.at(-1),s=i&&n?[[`energy_compensation`,`True`]]:[];if(a){let n=[...t,...vu(e),...s];o.push(`material = ${Su(`urushi.coat`,n,`material`)}`);continue}let c=Su(`urushi.dielectric`,t),l=[...vu(e),...s,[`fast`,`True`]];o.push(`material = ${Su(`urushi.layer`,l,`${c}, material`)}`)}(a||r.coats.length===0)&&o.push(`material = urushi.encode(material)`);let s=n!==0&&Rn(r)?`material.rotated(${n})`:``,c=`np.array([[0.5, 0.0, np.sqrt(0.75)]])`;return o.push(...s?[`material = ${s}`]:[],``,`print(material.f(${c}, ${c} * [-1, 1, 1]))  # 1/sr`,`material.save("${yu(t)}.safetensors")`,``),o.join(`
`)}function vu(e){let t=`sigmaT`in e?[[`albedo`,e.albedo],[`sigma_t`,e.sigmaT]]:[[`color`,e.color],[`body`,e.body],[`body_color`,e.bodyColor]],{g:n,thickness:r=1}=e;return[...t,[`g`,n],...r===1?[]:[[`thickness`,r]]]}function yu(e){return e.toLowerCase().replace(/[^a-z0-9]+/g,`-`).replace(/^-|-$/g,``)||`material`}function bu(e){switch(e.kind){case`conductor`:return`r0`in e?Su(`urushi.conductor`,[...xu(e),[`r0`,e.r0]]):Su(`urushi.conductor`,[...xu(e),[`eta`,e.eta],[`k`,e.k]]);case`dielectric`:return Su(`urushi.dielectric`,[...xu(e),[`ior`,e.ior]]);case`diffuse`:return Su(`urushi.diffuse`,[[`reflectance`,e.reflectance]]);case`codes`:throw new I(`A loaded material cannot be written as a description; save the state as JSON.`)}}function xu(e){let{alpha:t,alphaV:n}=e;return n===void 0?[[`alpha`,t]]:[[`alpha_u`,t],[`alpha_v`,n]]}function Su(e,t,n=``){let r=t.map(([e,t])=>`${e}=${Cu(t)}`);return`${e}(${[...n?[n]:[],...r].join(`, `)})`}function Cu(e){return typeof e==`object`?`(${e.join(`, `)})`:String(e)}function wu(e){return`${Au(Eu(e),0,`material`).join(`
`)}\n`}function Tu(e){return`import urushi  # registers the plugin\n\nbsdf = ${ju(Eu(e),0).join(`
`).trimStart()}\n`}function Eu(e){let{rotation:t=0}=e,n=An(e),r=n.coats.reduceRight((e,t)=>Ou(t,e),ku(n.bottom));if(e.energyCompensation===!0&&n.coats.length>0&&(r.switches=[`energy_compensation`]),!Rn(n)||t===0)return r;if(n.coats.length===0)throw new I(`Mitsuba turns no tangent of a bare surface; set the angle to 0, or save the material.`);return r.values.push([`rotation`,t]),r}function Du(e){let{alpha:t,alphaV:n}=e;return n===void 0?[[`alpha`,t]]:[[`alpha_u`,t],[`alpha_v`,n]]}function Ou(e,t){return{type:`neural_layered`,strings:[],values:[...Du(e),[`int_ior`,e.ior],...vu(e)],inner:t}}function ku(e){let t=[`distribution`,`ggx`];switch(e.kind){case`conductor`:if(`r0`in e){let n=[...Du(e),[`specular_reflectance`,e.r0]];return{type:`roughconductor`,strings:[t,[`material`,`none`]],values:n,inner:null}}return{type:`roughconductor`,strings:[t],values:[...Du(e),[`eta`,e.eta],[`k`,e.k]],inner:null};case`diffuse`:return{type:`diffuse`,strings:[],values:[[`reflectance`,e.reflectance]],inner:null};case`dielectric`:throw new I(`Mitsuba has no opaque dielectric; choose another bottom.`);case`codes`:throw new I(`A loaded material is rendered from its own file, by the plugin neural_brdf.`)}}function Au(e,t,n){let r=`    `.repeat(t),i=n===null?` name="bottom"`:` id="${n}"`,a=[`${r}<bsdf type="${e.type}"${i}>`];for(let[t,n]of e.strings)a.push(`${r}    <string name="${t}" value="${n}"/>`);for(let t of e.switches??[])a.push(`${r}    <boolean name="${t}" value="true"/>`);for(let[t,n]of e.values){let e=typeof n==`number`&&!Mu(t)?`float`:`rgb`;a.push(`${r}    <${e} name="${t}" value="${Nu(n)}"/>`)}return e.inner!==null&&a.push(...Au(e.inner,t+1,null)),[...a,`${r}</bsdf>`]}function ju(e,t){let n=`    `.repeat(t+1),r=[`${`    `.repeat(t)}{`,`${n}"type": "${e.type}",`];for(let[t,i]of e.strings)r.push(`${n}"${t}": "${i}",`);for(let t of e.switches??[])r.push(`${n}"${t}": True,`);for(let[t,i]of e.values){let e=typeof i==`number`&&!Mu(t)?i:`{"type": "rgb", "value": [${Nu(i)}]}`;r.push(`${n}"${t}": ${e},`)}if(e.inner!==null){let[i,...a]=ju(e.inner,t+1);r.push(`${n}"bottom": ${i.trimStart()}`,...a),r[r.length-1]+=`,`}return[...r,`${`    `.repeat(t)}}`]}function Mu(e){return[`reflectance`,`specular_reflectance`,`k`,`eta`].includes(e)}function Nu(e){return typeof e==`number`?String(e):e.join(`, `)}function Pu({vertices:e,faces:t}){let n=[`x`,`y`,`z`,`nx`,`ny`,`nz`,`u`,`v`].map(e=>`property float ${e}`),r=[`ply`,`format binary_little_endian 1.0`,`element vertex ${e.length/8}`,...n,`element face ${t.length/3}`,`property list uchar int vertex_indices`,`end_header
`].join(`
`),i=new TextEncoder().encode(r),a=new Uint8Array(i.length+4*e.length+13*t.length/3);a.set(i);let o=new DataView(a.buffer),s=i.length;for(let t of e)o.setFloat32(s,t,!0),s+=4;for(let e=0;e<t.length;e+=3){o.setUint8(s,3);for(let n=0;n<3;n++)o.setInt32(s+1+4*n,t[e+n],!0);s+=13}return a}function Fu(e){let{mesh:t}=e;return Lt({"scene.xml":new TextEncoder().encode(Iu(e)),"object.ply":Pu(t),[`environment.${e.environment.suffix}`]:e.environment.bytes,"material.safetensors":e.material})}function Iu(e){let{mesh:t,view:n,rotation:r,width:i,height:a,environment:o}=e,{eye:s,up:c,forward:l}=Fo(t,n,i/a),u=s.map((e,t)=>e+l[t]);return`<scene version="3.0.0">
    <default name="spp" value="256"/>
    <integrator type="path"/>
    <sensor type="perspective">
        <string name="fov_axis" value="y"/>
        <float name="fov" value="${360/Math.PI*Math.atan(Math.hypot(...c))}"/>
        <transform name="to_world">
            <lookat origin="${s.join(`, `)}" target="${u.join(`, `)}" up="${c.join(`, `)}"/>
        </transform>
        <film type="hdrfilm">
            <integer name="width" value="${i}"/>
            <integer name="height" value="${a}"/>
            <string name="pixel_format" value="rgb"/>
            <rfilter type="box"/>
        </film>
        <sampler type="independent">
            <integer name="sample_count" value="$spp"/>
        </sampler>
    </sensor>
    <emitter type="envmap" id="environment">
        <string name="filename" value="environment.${o.suffix}"/>
        <transform name="to_world">
            <rotate x="1" angle="90"/>
            <rotate z="1" angle="${r}"/>
        </transform>
    </emitter>
${e.lights.map(e=>Lu(e,r)).join(``)}\
    <shape type="ply" id="object">
        <string name="filename" value="object.ply"/>
        <bsdf type="neural_brdf">
            <string name="filename" value="material.safetensors"/>
        </bsdf>
    </shape>
</scene>
`}function Lu({direction:e,power:t},n){let r=e.map(e=>-e).join(`, `);return`    <emitter type="directional">
        <rgb name="irradiance" value="${t.join(`, `)}"/>
        <transform name="to_world">
            <lookat origin="0, 0, 0" target="${r}" up="0.36, 0.48, 0.8"/>
            <rotate z="1" angle="${n}"/>
        </transform>
    </emitter>
`}var Ru=[`Picture`,`Material`,`Code`,`Share`];function zu(){if(X.value===null)throw new I(`The networks are not loaded yet.`);return X.value}async function Bu(){let e=jn(W.value),t=$s(W.value)?.table,n=await zu().cores.of(e),r=await n.layer(e);if(r.compensation!==void 0)throw new I(`The codes of an anisotropic material have no energy compensation; switch it off, or save Python or a Mitsuba BSDF.`);return{core:n,codes:{...r,table:t??r.table}}}var Vu=()=>W.value.rotation??0;async function Hu(){let{bottom:e}=W.value;if(e.kind!==`texels`){let{core:e,codes:t}=await Bu();return pi(t,e,Vu())}let t=ti.value.get(e.texture);if(t===void 0)throw new I(`The texture was not opened.`);return t.texture.file}var Uu=[{group:`Picture`,label:`Picture`,hint:`PNG, as it is seen`,save:async e=>{$(`${e}.png`,await zu().picture()),Wu()}},{group:`Picture`,label:`Radiance`,hint:`EXR, the picture in linear light`,save:async e=>{$(`${e}.exr`,new Blob([Ts(await zu().radiance())])),Wu()}},{group:`Material`,label:`Material`,hint:`safetensors, for urushi.load`,save:async e=>$(`${e}.safetensors`,new Blob([await Hu()]))},{group:`Material`,label:`Mitsuba XML`,hint:`a BSDF for a scene file`,save:e=>$(`${e}.xml`,Zu(wu(W.value)))},{group:`Material`,label:`Mitsuba dictionary`,hint:`the same for mi.load_dict`,save:e=>$(`${e}-dict.py`,Zu(Tu(W.value)))},{group:`Share`,label:`Mitsuba scene`,hint:`ZIP: object, camera, light and material`,save:async e=>{let t={...await zu().scene(),material:await Hu()};$(`${e}-scene.zip`,new Blob([Fu(t)]))}},{group:`Code`,label:`Python`,hint:`a program with urushi`,save:e=>$(`${e}.py`,Zu(_u(W.value)))},{group:`Code`,label:`MaterialX`,hint:`an open_pbr_surface, without what that lacks`,save:e=>{let{text:t,lost:n}=_i(W.value);$(`${e}.mtlx`,Zu(t)),n&&Hr(n)}},{group:`Share`,label:`State`,hint:`JSON, to open here again`,save:e=>$(`${e}.json`,Zu(vc(U.value,2)))}];function Wu(){let{converged:e,gathered:t}=zu().painter;e.value||Hr(`The picture was saved while refining, with ${Math.round(100*t.value)} % of its frames; wait until it has converged, or save 2 × or 4K, which are drawn to the end.`)}var Gu={"2x":`2 ×`,"4K":`4K`};async function Ku(e,t){$(`${t}-${e}.png`,await zu().largePicture(e))}var qu={group:`Share`,label:`Copy the address`,hint:`it holds the whole state`,save:async()=>{let e=new URL(`#${yc(U.value)}`,location.href).href;try{await navigator.clipboard.writeText(e)}catch{throw new I(`The browser gives the page no clipboard; copy the address from the address bar.`)}Nr(`The address was copied.`)}},Ju=Object.keys(Kr);async function Yu(e,t){let{core:n,codes:r}=await Bu(),i=Yr(await Jr(e,n.widths),r,Vu());$(`${t}${Kr[e].suffix}`,Zu(i)),r.table.isOfCodes||Hr(`The shader code has the codes of the material; for its table, save the material and run urushi export.`)}async function Xu(e){let{core:t}=await Bu(),n=await t.basisTexels();$(`urushi-basis.${e}`,pu(n,e))}function $(e,t){let n=document.createElement(`a`);n.href=URL.createObjectURL(t),n.download=e,n.click(),setTimeout(()=>URL.revokeObjectURL(n.href),1e4)}function Zu(e){return new Blob([e],{type:`text/plain`})}function Qu({onDone:e}){let t=async n=>{e();try{await n(yu(W.value.name))}catch(e){q(e,()=>void t(n))}},n=wt()?Uu:[...Uu,qu];return Ru.map(e=>Z(`section`,{children:[Z(`h2`,{children:e}),Z(`ul`,{children:[n.filter(t=>t.group===e).map(({label:e,hint:n,save:r})=>Z(`li`,{children:Z(`button`,{type:`button`,onClick:()=>void t(r),children:[Z(`span`,{children:e}),Z(`small`,{children:n})]})},e)),e===`Picture`&&Z(`li`,{class:`languages`,children:[Z(`small`,{children:`Larger, drawn to the end`}),Z(`div`,{role:`group`,"aria-label":`Larger picture`,children:Object.entries(Gu).map(([e,n])=>Z(`button`,{type:`button`,onClick:()=>void t(t=>Ku(e,t)),children:n},e))})]}),e===`Code`&&Z(`li`,{class:`languages`,children:[Z(`small`,{children:`Shaders of f, pdf and sample`}),Z(`div`,{role:`group`,"aria-label":`Shader code`,children:Ju.map(e=>Z(`button`,{type:`button`,onClick:()=>void t(t=>Yu(e,t)),children:Kr[e].title},e))}),Z(`small`,{children:`The texture that their f reads: GPU, NumPy, OSL`}),Z(`div`,{role:`group`,"aria-label":`Texture of the basis`,children:Object.keys(lu).map(e=>Z(`button`,{type:`button`,onClick:()=>void t(()=>Xu(e)),children:lu[e]},e))})]})]})]},e))}var $u={neutral:`Neutral (Khronos)`,filmic:`Filmic (ACES)`,none:`None (sRGB)`},ed={environment:`Environment`,colour:`Colour`,transparent:`Transparent`},td=`#f2f2f2`;function nd({onDone:e}){let{view:t,background:n,tone:r,turntable:i}=U.value,a=(e,t=``)=>Rr({...U.value,...e},t),o=n.startsWith(`#`),s=async()=>{e();try{await document.getElementById(Wl).requestFullscreen()}catch{q(new I(`The browser does not let the page fill the screen.`))}};return Z(x,{children:[Z(iu,{label:`Field of view`,hint:`Angle of the lens; the object keeps its size. Double click: reset.`,text:`${t.fov}°`,value:t.fov,low:5,high:60,step:1,fallback:V.view.fov,onInput:e=>K({view:{...U.value.view,fov:e}})}),Z(`label`,{children:[Z(`span`,{children:`Background`}),Z(`select`,{value:o?`colour`:n,onChange:({currentTarget:{value:e}})=>a({background:e===`colour`?td:e}),children:Object.entries(ed).map(([e,t])=>Z(`option`,{value:e,children:t},e))}),o&&Z(`input`,{type:`color`,class:`swatch`,"aria-label":`Colour of the background`,value:n,onInput:e=>a({background:e.currentTarget.value},`background`)})]}),Z(`label`,{children:[Z(`span`,{children:`Tone curve`}),Z(`select`,{value:r,onChange:e=>a({tone:e.currentTarget.value}),children:sr.map(e=>Z(`option`,{value:e,children:$u[e]},e))})]}),Z(`label`,{title:Xl()?`Your system asks for less motion.`:void 0,children:[Z(`span`,{children:`Turntable`}),Z(`input`,{type:`checkbox`,checked:i,disabled:Xl(),onChange:e=>K({turntable:e.currentTarget.checked})})]}),Z(`div`,{class:`pair`,children:[Z(`button`,{type:`button`,class:`text-button`,onClick:()=>K({view:V.view}),children:`Reset camera`}),document.fullscreenEnabled&&Z(`button`,{type:`button`,class:`text-button`,onClick:()=>void s(),children:`Full screen`})]})]})}function rd(){let e=A(null),{comparison:t,active:n}=U.value,r=t===`off`?``:`AB`[n];return Z(`header`,{class:`top`,children:[Z(`h1`,{children:[Z(`svg`,{viewBox:`0 0 20 20`,"aria-hidden":`true`,children:[Z(`path`,{d:`M3 13.5 10 17l7-3.5M3 10l7 3.5L17 10`}),Z(`path`,{class:`lacquer`,d:`m10 3 7 3.5-7 3.5-7-3.5Z`})]}),`Urushi`]}),Z(cu,{kind:`presets`,name:`Material ${r} ${rr(W.value)}: choose another`,label:Z(x,{children:[r&&Z(`b`,{class:`badge`,children:r}),` `,Z(`span`,{class:`current`,children:rr(W.value)}),Z(Q,{name:`down`})]}),children:e=>Z(id,{onChosen:e})}),Z(`span`,{class:`spacer`}),Z(`button`,{type:`button`,class:`icon-button`,"aria-label":`Undo`,title:`Undo (Ctrl+Z)`,"aria-disabled":!Ir.value,onClick:zr,children:Z(Q,{name:`undo`})}),Z(`button`,{type:`button`,class:`icon-button`,"aria-label":`Redo`,title:`Redo (Ctrl+Shift+Z)`,"aria-disabled":!Lr.value,onClick:Br,children:Z(Q,{name:`redo`})}),Z(`input`,{ref:e,type:`file`,hidden:!0,multiple:!0,accept:`.hdr,.exr,.obj,.glb,.gltf,.json,.safetensors,.mtlx,.binary,.bsdf`,onChange:e=>{oc([...e.currentTarget.files??[]]),e.currentTarget.value=``}}),Z(`button`,{type:`button`,class:`text-button`,"aria-label":`Open`,title:`A material (.safetensors, .mtlx), a measured BRDF (.binary, .bsdf), a panorama (.hdr, .exr), a mesh (.obj, .glb, .gltf) or a saved state (.json); or drop it on the page`,onClick:()=>e.current?.click(),children:[Z(Q,{name:`open`}),Z(`span`,{children:`Open`})]}),Z(cu,{kind:`view`,name:`View`,label:Z(x,{children:[Z(Q,{name:`sliders`}),Z(`span`,{children:`View`})]}),children:e=>Z(nd,{onDone:e})}),Z(cu,{kind:`save`,name:`Save`,label:Z(x,{children:[Z(Q,{name:`save`}),Z(`span`,{children:`Save`})]}),children:e=>Z(Qu,{onDone:e})}),Z(Ol,{})]})}function id({onChosen:e}){let t=A(null),n=A({text:``,time:0}),r=()=>t.current?.querySelector(`[tabindex='0']`);Ae(()=>{Zs(),r()?.focus()},[]);let i=[...ac.value,...nr,...Ys.value],a=Math.max(i.findIndex(({name:e})=>e===W.value.name),0);return Z(`ul`,{ref:t,onKeyDown:e=>{let r=[...t.current?.querySelectorAll(`button`)??[]],a=r.indexOf(document.activeElement),o=r.filter(({offsetTop:e})=>e===r[0]?.offsetTop).length,{key:s,timeStamp:c}=e,l={ArrowLeft:-1,ArrowRight:1,ArrowUp:-o,ArrowDown:o}[s],u=l===void 0?-1:a+l;if(s===`Home`&&(u=0),s===`End`&&(u=r.length-1),s.length===1&&s!==` `&&!e.ctrlKey&&!e.metaKey){let e=c<n.current.time+700?n.current.text+s:s;n.current={text:e,time:c},u=i.findIndex(({name:t})=>t.toLowerCase().startsWith(e.toLowerCase()))}else if(u<0&&l===void 0)return;e.preventDefault(),r[u]?.focus()},children:i.map((t,n)=>Z(`li`,{children:Z(`button`,{type:`button`,tabIndex:n===a?0:-1,"aria-pressed":t.name===W.value.name,onClick:()=>{G(t),e()},children:[Z(qc,{of:t}),Z(`span`,{children:t.name})]})},t.name))})}function ad(){return Z(x,{children:[Z(`button`,{type:`button`,class:`skip`,onClick:()=>document.getElementById(`material`)?.focus(),children:`Skip to the layers`}),Z(rd,{}),Z(`main`,{children:[Z(Gl,{}),Z(ou,{}),Z(`div`,{class:`column`,children:[Z(`aside`,{id:`material`,tabIndex:-1,"aria-label":`Material`,children:[U.value.comparison!==`off`&&Z(sd,{}),Z(od,{}),Z(Cl,{})]}),Z(jl,{})]})]}),Z(kl,{}),Z(`p`,{class:`spoken`,role:`status`,children:jr.value})]})}function od(){let{name:e}=W.value;return Z(`input`,{type:`text`,class:`name`,"aria-label":`Name of the material`,maxLength:80,autocomplete:`off`,spellcheck:!1,value:e,onChange:({currentTarget:t})=>{let n=t.value.trim();n===``?t.value=e:n!==e&&G({...W.value,name:n})},onKeyDown:({key:e,currentTarget:t})=>{e===`Enter`&&t.blur()}})}function sd(){let{active:e,materials:t}=U.value,[n,r]=t,i=e===0?`B`:`A`,a=(e,t)=>{Rr({...U.value,materials:e}),Nr(t)},o=t[e];return Z(x,{children:[Z(cd,{}),Z(`div`,{class:`pair`,children:[Z(`button`,{type:`button`,class:`quiet`,onClick:()=>a([o,o],`The material was copied to ${i}.`),children:[`Copy to `,i]}),Z(`button`,{type:`button`,class:`quiet`,onClick:()=>a([r,n],`A and B were swapped.`),children:[Z(Q,{name:`swap`}),` Swap`]})]})]})}function cd(){let{active:e,materials:t}=U.value;return Z(`div`,{class:`segments chooser`,role:`group`,"aria-label":`Material on the cards`,children:[0,1].map(n=>Z(`button`,{type:`button`,"aria-pressed":e===n,onClick:()=>Rr({...U.value,active:n}),children:[Z(`b`,{children:n===0?`A`:`B`}),` `,rr(t[n])]},n))})}var ld=`button, select, input, [tabindex]`;function ud(){let e=null;document.addEventListener(`focusin`,({target:t})=>{e=t}),new MutationObserver(t=>{if(e===null||e.isConnected||document.activeElement!==document.body)return;let n=t.find(({removedNodes:t})=>[...t].some(t=>t.contains(e)));if(n===void 0)return;let r=[n.nextSibling,n.previousSibling,n.target].filter(e=>e instanceof Element&&e.isConnected).map(e=>[...e.querySelectorAll(ld)]),i=e.getAttribute(`title`),a=r.flat().find(e=>i&&e.title===i),o=r.find(e=>e.length>0)?.[0],s=n.target.parentElement?.querySelector(ld);(a??o??s)?.focus()}).observe(document.body,{childList:!0,subtree:!0})}var dd=location.hash.length>1;dd&&Ur(()=>bc(location.hash,Hr),!1);var fd=location.hash,pd=0;F(()=>{U.value,wt()||pd!==0||(pd=window.setTimeout(()=>{pd=0,fd=`#${yc(U.peek())}`,history.replaceState(null,``,fd)},400))}),F(()=>{document.title=`${rr(W.value)} · Urushi`}),window.addEventListener(`hashchange`,()=>{location.hash!==fd&&Ur(()=>bc(location.hash,Hr),!0)}),window.addEventListener(`keydown`,e=>{let t=e.ctrlKey||e.metaKey?e.key.toLowerCase():``;e.target instanceof HTMLInputElement&&e.target.type===`text`||t!==`z`&&t!==`y`||(e.preventDefault(),t===`y`||e.shiftKey?Br():zr())}),window.addEventListener(`unhandledrejection`,e=>q(e.reason)),mc(document.documentElement),ud();var md=document.getElementById(`page`);md.replaceChildren(),D(Z(ad,{}),md),Ks(dd);